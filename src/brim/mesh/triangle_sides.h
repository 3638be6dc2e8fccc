#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <tuple>
#include <vector>

#include "brim/mesh/tri_mesh.h"

namespace brim {

/// One side of a triangle: its edge with a < b, and whether the triangle traverses it from a to b.
struct Side {
  std::int32_t a, b;
  std::int32_t triangle;
  std::int8_t corner;
  bool forward;
};

/// All sides, grouped by edge, in the order of their triangles.
inline std::vector<Side> sorted_sides(std::span<const Triangle> triangles) {
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = triangles[t][k], b = triangles[t][(k + 1) % 3];
      sides.push_back(
          {std::min(a, b), std::max(a, b), static_cast<std::int32_t>(t), static_cast<std::int8_t>(k), a < b});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& x, const Side& y) {
    return std::tie(x.a, x.b, x.triangle, x.corner) < std::tie(y.a, y.b, y.triangle, y.corner);
  });
  return sides;
}

/// Calls f(first, last) for each group of sides on the same edge.
template <class F>
void for_each_edge(const std::vector<Side>& sides, const F& f) {
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t j = i + 1;
    while (j < sides.size() && sides[j].a == sides[i].a && sides[j].b == sides[i].b) ++j;
    f(sides.data() + i, sides.data() + j);
    i = j;
  }
}

}  // namespace brim
