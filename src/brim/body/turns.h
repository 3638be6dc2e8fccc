#pragma once

#include <span>

#include "brim/math/types.h"

namespace brim {

/// Optional interface of bodies whose matter turns in a step instead of moving along its velocity u: a point of a part
/// goes from x to x + dt (u − ω × d) + (R − 1) d + ½ dt² (a + α × d), d = x − c, R the rotation by dt ω.
/// Tests: tests/world/turntable_test.cpp
class Turns {
 public:
  struct Turn {
    Vec3 center = Vec3::Zero();        ///< [m] c
    Vec3 spin = Vec3::Zero();          ///< [rad/s] ω
    Vec3 acceleration = Vec3::Zero();  ///< [m/s²] a, of the centre when no force acts
    Vec3 spin_change = Vec3::Zero();   ///< [rad/s²] α, likewise
  };
  virtual ~Turns() = default;
  /// @param v  of the body; positions are those of the last update  @param part  shape (parts)
  virtual void turns(std::span<const double> v, std::span<Turn> part) const = 0;
};

}  // namespace brim
