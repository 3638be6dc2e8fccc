#pragma once

#include "brim/raster/convex_distance.h"
#include "brim/raster/shape.h"

namespace brim {

/// A placed convex solid.
struct PlacedConvex {
  const ConvexDistance* solid;
  Pose pose;
  /// A point that is farthest along a direction, [m].
  Vec3 support(const Vec3& direction) const {
    return pose.rotation * solid->support(pose.rotation.transpose() * direction) + pose.translation;
  }
};

/// Closest points of two convex solids by their farthest points along directions (Gilbert, Johnson and Keerthi 1988):
/// however long and thin they are, and wherever the search starts.
/// @param from  direction from b to a, not zero  @param accuracy  [m] of their distance
/// @return false when the solids overlap, or extend to infinity along a direction that was tried
/// Tests: tests/response/closest_points_test.cpp
bool closest_points(const PlacedConvex& a, const PlacedConvex& b, const Vec3& from, double accuracy, Vec3& on_a,
                    Vec3& on_b);

}  // namespace brim
