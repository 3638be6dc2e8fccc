#pragma once

#include "brim/math/types.h"

namespace brim {

/// Optional interface of convex shapes whose exact signed distance has a gradient at every point outside: their
/// surfaces can be found between the nodes of a grid.
/// Tests: tests/raster/shape_test.cpp
class ConvexDistance {
 public:
  virtual ~ConvexDistance() = default;
  /// Signed distance at p, [m]; its gradient, a unit vector away from the surface, or zero where there is none.
  /// @param p  [m] shape's frame
  virtual double distance_and_gradient(const Vec3& p, Vec3& gradient) const = 0;
};

}  // namespace brim
