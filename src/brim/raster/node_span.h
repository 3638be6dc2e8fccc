#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <span>
#include <vector>

#include "brim/core/parallel.h"
#include "brim/core/simd.h"
#include "brim/grid/tile.h"

namespace brim {

/// The grid nodes lo <= (i, j, k) <= hi; empty when lo > hi along some axis.
struct NodeSpan {
  std::int32_t lo[3], hi[3];
  bool empty() const { return lo[0] > hi[0] || lo[1] > hi[1] || lo[2] > hi[2]; }
  bool meets(const NodeSpan& other) const {
    bool apart = false;
    for (int a = 0; a < 3; ++a) apart |= lo[a] > other.hi[a] || hi[a] < other.lo[a];
    return !apart;
  }
  /// Extended by `more` nodes on each side.
  NodeSpan grown(std::int32_t more) const {
    return {{lo[0] - more, lo[1] - more, lo[2] - more}, {hi[0] + more, hi[1] + more, hi[2] + more}};
  }
  static constexpr NodeSpan all();
};

/// [voxels] coordinates are clamped to ± this; NaN becomes the lower limit.
inline constexpr double kFarthestNode = 1e9;

constexpr NodeSpan NodeSpan::all() {
  constexpr auto n = static_cast<std::int32_t>(kFarthestNode);
  return {{-n, -n, -n}, {n, n, n}};
}

/// Floor of a coordinate in voxels, without a library call.
inline std::int32_t node_below(double voxels) {
  const double v = voxels > -kFarthestNode ? std::min(voxels, kFarthestNode) : -kFarthestNode;
  const auto n = static_cast<std::int32_t>(v);
  return n - (static_cast<double>(n) > v);
}
inline std::int32_t node_above(double voxels) { return -node_below(-voxels); }

/// The nodes in a box extended by `slack` voxels.
inline NodeSpan nodes_in(const Aabb& box, double h, double slack) {
  const double inverse = 1.0 / h;
  NodeSpan s;
  for (int a = 0; a < 3; ++a)
    s.lo[a] = node_above(box.lo[a] * inverse - slack), s.hi[a] = node_below(box.hi[a] * inverse + slack);
  return s;
}

/// The nodes next to each vertex of a mesh, from which the nodes in its elements' boxes follow by a few integer
/// comparisons.  Tests: tests/raster/node_span_test.cpp
class VertexNodes {
 public:
  /// @param slack  [voxels] extension of the boxes on each side
  void build(std::span<const Vec3> x, double h, double slack) {
    next_.resize(x.size());
    parallel_blocks(x.size(), 4096, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        const NodeSpan s = nodes_in({x[v], x[v]}, h, slack);
        for (int a = 0; a < 3; ++a) next_[v][a] = s.lo[a], next_[v][3 + a] = -s.hi[a];
      }
    });
  }
  template <std::size_t N>
  NodeSpan around(const std::array<std::int32_t, N>& corners) const {
    return around(std::span<const std::int32_t, N>(corners));
  }
  /// @param corners  at least one
  template <std::size_t N>
  NodeSpan around(std::span<const std::int32_t, N> corners) const {
    const std::int32_t* first = next_[corners[0]].data();
    NodeSpan s;
    std::int32_t least[6];
    for (int a = 0; a < 6; ++a) least[a] = first[a];
    for (std::size_t i = 1; i < corners.size(); ++i) {
      const std::int32_t* at = next_[corners[i]].data();
      for (int a = 0; a < 6; ++a) least[a] = std::min(least[a], at[a]);
    }
    for (int a = 0; a < 3; ++a) s.lo[a] = least[a], s.hi[a] = -least[3 + a];
    return s;
  }

 private:
  std::vector<std::array<std::int32_t, 8>> next_;  // per vertex: nodes above along x, y, z, minus those below
};

}  // namespace brim
