#pragma once

#include <span>

#include "brim/body/body.h"

namespace brim {

/// How a rigid body moves over a sub-step at the velocities it has now: its points follow arcs, where the sub-step's
/// system lets them move straight by dt u.  Tests: tests/world/arc_test.cpp
class Arc {
 public:
  /// Of bodies that are no rigid frame: all points move straight.
  Arc() = default;
  /// @param q, v  of the body, now; v may be empty, at rest
  Arc(const Body& body, std::span<const double> q, std::span<const double> v, double dt);

  /// [m] Place of a point x of the body at the end of the sub-step, minus x + dt u(x).
  Vec3 bend(const Vec3& x) const;
  /// Direction of the body at the end of the sub-step.
  Vec3 turned(const Vec3& n) const { return rotation_ * n; }

 private:
  Vec3 center_ = Vec3::Zero(), spin_ = Vec3::Zero(), way_ = Vec3::Zero();
  Mat3 rotation_ = Mat3::Identity();
};

}  // namespace brim
