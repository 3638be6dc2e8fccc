#pragma once

#include <span>

#include "brim/math/types.h"

namespace brim {

/// Optional interface of bodies whose matter turns in a step instead of moving along its velocity: a point goes from x
/// to x + dt (u − ω × d) + (R − 1) d, d = x − c, R the rotation by dt ω.
/// Tests: tests/world/turntable_test.cpp
class Turns {
 public:
  struct Turn {
    Vec3 center = Vec3::Zero();  ///< [m] c
    Vec3 spin = Vec3::Zero();    ///< [rad/s] ω
  };
  virtual ~Turns() = default;
  /// @param v  of the body; positions are those of the last update
  virtual Turn turn(std::span<const double> v) const = 0;
};

}  // namespace brim
