#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "brim/core/simd.h"
#include "brim/grid/tile.h"
#include "brim/math/wide_vectors.h"
#include "brim/raster/tile_bins.h"

namespace brim {

/// Scratch of one block while primitives are splatted into it, eight nodes of a row at a time in single precision.
/// Positions are in voxels from the block's first node, so that a float resolves 1e-6 voxels anywhere in the world;
/// nodes outside the wanted octants hold undefined values.
struct BlockScratch {
  alignas(32) float value[kBlockNodes];           ///< squared or signed distance, [voxels² or voxels]
  alignas(32) std::int32_t nearest[kBlockNodes];  ///< primitive that gives the value, −1 when none is near
  alignas(32) std::int32_t holder[kBlockNodes];   ///< element that contains the node, −1 for none
};

BRIM_INLINE WideFloats wide(float x) { return x - WideFloats{}; }
BRIM_INLINE WideIds wide(std::int32_t x) { return x - WideIds{}; }
BRIM_INLINE WideFloats wide_max(const WideFloats& a, const WideFloats& b) { return a > b ? a : b; }
BRIM_INLINE WideFloats wide_min(const WideFloats& a, const WideFloats& b) { return a < b ? a : b; }
/// True when any lane of a comparison is true.
BRIM_INLINE bool any_lane(const WideIds& flags) {
  typedef std::int64_t Pair __attribute__((vector_size(sizeof(LaneIds))));
  const LaneIds half =
      __builtin_shufflevector(flags, flags, 0, 1, 2, 3) | __builtin_shufflevector(flags, flags, 4, 5, 6, 7);
  const auto p = std::bit_cast<Pair>(half);
  return (p[0] | p[1]) != 0;
}

/// 0 to 7: numbers of the lanes.
BRIM_INLINE WideFloats lane_numbers() { return WideFloats{0.0f, 1.0f, 2.0f, 3.0f, 4.0f, 5.0f, 6.0f, 7.0f}; }

/// Starts of the groups of eight nodes that contain the nodes lo to hi of a row: at most two, within the block.
struct RowGroups {
  int count, start[2];
};
BRIM_INLINE RowGroups row_groups(int lo, int hi) {
  constexpr int kLast = kBlockSize - kWideLanes;
  const int first = std::min(lo, kLast);
  return {hi - first < kWideLanes ? 1 : 2, {first, kLast}};
}

// Arithmetic as plain loops, to be inlined into functions compiled for wide registers.
BRIM_INLINE Vec3 times(double s, const Vec3& v) { return {s * v[0], s * v[1], s * v[2]}; }
BRIM_INLINE Vec3 crossed(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
BRIM_INLINE double dotted(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// A position in voxels from the block's first node.
BRIM_INLINE Vec3 in_voxels(const Vec3& x, const Vec3& origin, double inverse_h) {
  return {(x[0] - origin[0]) * inverse_h, (x[1] - origin[1]) * inverse_h, (x[2] - origin[2]) * inverse_h};
}

/// Nodes of a block in the bounding box of some points, extended by `reach`, clipped to the wanted nodes.
/// @param p, reach  in voxels from the first node
template <int N>
BRIM_INLINE NodeRange nodes_around(const Vec3 (&p)[N], const Vec3& reach, const NodeRange& clip) {
  constexpr double kUp = 16.0;  // keeps values positive before conversion to integers
  NodeRange r;
  for (int a = 0; a < 3; ++a) {
    double least = p[0][a], most = p[0][a];
    for (int i = 1; i < N; ++i) least = std::min(least, p[i][a]), most = std::max(most, p[i][a]);
    least -= reach[a] + 1e-9, most += reach[a] + 1e-9;
    // Numbers out of range and NaN are clipped to the range's ends.
    const double lo = least > -1.0 ? std::min(least, double{kBlockSize}) : -1.0;
    const double hi = most < kBlockSize ? std::max(most, -1.0) : double{kBlockSize};
    r.lo[a] = std::max(clip.lo[a], static_cast<int>(kUp) - static_cast<int>(kUp - lo));
    r.hi[a] = std::min(clip.hi[a], static_cast<int>(kUp + hi) - static_cast<int>(kUp));
  }
  return r;
}

/// Calls f(first node) for groups of eight nodes that contain all nodes read by the wanted octants and their stencils,
/// maybe others too; some nodes twice.
template <class F>
BRIM_INLINE void for_wanted_groups(Octants wanted, const F& f) {
  constexpr int kHalf = kTileSize / 2, kReach = kHalf + 2 * kHalo;
  for (int k = 0; k < kBlockSize; ++k)
    for (int j = 0; j < kBlockSize; ++j) {
      unsigned along_x = 0;  // bit 0: the lower half of the row, bit 1: the upper
      for (int z = 0; z < 2; ++z)
        for (int y = 0; y < 2; ++y)
          if (j >= kHalf * y && j < kHalf * y + kReach && k >= kHalf * z && k < kHalf * z + kReach)
            along_x |= wanted >> (2 * y + 4 * z) & 3u;
      if (along_x & 1) f(block_index(0, j, k));
      if (along_x & 2) f(block_index(kBlockSize - kWideLanes, j, k));
    }
}

/// ramp(d, w) of eight distances. @param inverse_w  1/w in the unit of d
BRIM_INLINE WideFloats wide_ramp(const WideFloats& d, float inverse_w) {
  const WideFloats t = wide_min(wide_max(d * inverse_w + 0.5f, WideFloats{}), wide(1.0f));
  return 1.0f - t * t * (3.0f - 2.0f * t);
}

/// Writes eight densities and their sources. @param group  index of the first of the nodes in the block
BRIM_INLINE void store_group(const WideFloats& rho, const WideIds& source, int group, DensityBlock& block) {
  store_lanes(block.rho + group, to_double(__builtin_shufflevector(rho, rho, 0, 1, 2, 3)));
  store_lanes(block.rho + group + kLanes, to_double(__builtin_shufflevector(rho, rho, 4, 5, 6, 7)));
  store_wide(source, block.source + group);
}

}  // namespace brim
