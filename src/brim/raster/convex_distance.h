#pragma once

#include "brim/math/types.h"

namespace brim {

/// Optional interface of convex shapes whose exact signed distance has a gradient at every outside point: their
/// surfaces can be located between grid nodes.
/// Tests: tests/raster/shape_test.cpp
class ConvexDistance {
 public:
  virtual ~ConvexDistance() = default;
  /// Signed distance at p, [m], and its gradient, a unit vector away from the surface, or zero where undefined.
  /// @param p  [m] shape's frame
  virtual double distance_and_gradient(const Vec3& p, Vec3& gradient) const = 0;
  /// A point of the solid that is farthest along a direction, [m]; infinite where there is none.
  /// @param direction  shape's frame, not zero
  virtual Vec3 support(const Vec3& direction) const = 0;
};

}  // namespace brim
