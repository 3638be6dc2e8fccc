#pragma once

#include "brim/math/types.h"
#include "brim/scene/node.h"
#include "brim/scene/placement.h"

namespace brim {

/// Copies in a circle: "around" of a "repeat".
struct Circle {
  Vec3 point = Vec3::Zero();  ///< [m] on the axis
  Vec3 axis = Vec3::UnitZ();  ///< unit
  int count = 1;              ///< copies, the first included
  double degrees = 0.0;       ///< from one copy to the next, right-handed about the axis

  /// The placement turned about the axis by k times the angle: x -> point + R (x - point). Rotation, velocities and the
  /// axes of prescribed motions turn as well. k = 0 changes no bit.
  Placement place(const Placement& first, int k) const;
};

/// Reads the circle of a "repeat". Tests: tests/scene/circle_test.cpp
/// @throws InputError  when the axis has no length, or two copies would lie on each other
Circle read_circle(const Node& around);

}  // namespace brim
