#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <span>

#include "brim/math/types.h"

namespace brim {

/// Lower bound of the distance of two triangles or segments, [m]: the widest gap between their projections on some
/// directions (separating axes). It is the distance itself between a face and a corner, two edges, or two corners; 0
/// where they intersect.
///   gap(n) = max(min n·b − max n·a, min n·a − max n·b) / |n|
/// @param a, b    [m]  two or three corners each
/// @param enough  [m]  a larger bound ends the search
/// Tests: tests/math/least_distance_test.cpp
inline double least_distance(std::span<const Vec3> a, std::span<const Vec3> b,
                             double enough = std::numeric_limits<double>::infinity()) {
  double most = 0.0;
  const auto look_along = [&](const Vec3& n) {
    const double length = most > enough ? 0.0 : n.norm();
    if (!(length > 0.0)) return;
    const auto bounds = [&](std::span<const Vec3> x, double& lo, double& hi) {
      lo = hi = n.dot(x[0]);
      for (const Vec3& corner : x.subspan(1)) lo = std::min(lo, n.dot(corner)), hi = std::max(hi, n.dot(corner));
    };
    double lo_a = 0.0, hi_a = 0.0, lo_b = 0.0, hi_b = 0.0;
    bounds(a, lo_a, hi_a), bounds(b, lo_b, hi_b);
    most = std::max(most, std::max(lo_b - hi_a, lo_a - hi_b) / length);
  };
  const auto edge = [](std::span<const Vec3> x, std::size_t k) { return Vec3(x[(k + 1) % x.size()] - x[k]); };
  // Normals of the faces, and of their edges within them.
  for (const auto& x : {a, b}) {
    if (x.size() < 3) continue;
    const Vec3 normal = edge(x, 0).cross(edge(x, 1));
    look_along(normal);
    for (std::size_t k = 0; k < x.size(); ++k) look_along(normal.cross(edge(x, k)));
  }
  // Of two edges, and from corner to corner.
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j) look_along(edge(a, i).cross(edge(b, j))), look_along(a[i] - b[j]);
  return most;
}

}  // namespace brim
