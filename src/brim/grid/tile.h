#pragma once

#include <algorithm>
#include <compare>
#include <cstdint>
#include <vector>

#include "brim/math/types.h"

namespace brim {

/// Nodes per side of a tile. Node (i, j, k) sits at h (i, j, k); tile (x, y, z) owns nodes 8x .. 8x+7 and so on.
inline constexpr int kTileSize = 8;
/// Rings of neighbouring nodes around a tile's own, for the 3x3x3 stencils.
inline constexpr int kHalo = 1;
inline constexpr int kBlockSize = kTileSize + 2 * kHalo;
inline constexpr int kBlockNodes = kBlockSize * kBlockSize * kBlockSize;

/// Integer coordinates of a tile at one level.
struct TileKey {
  std::int32_t x = 0, y = 0, z = 0;
  auto operator<=>(const TileKey&) const = default;
};

/// Along one axis, the tile that owns a node: node / kTileSize, rounded down.
template <class Int>
constexpr Int tile_of_node(Int node) {
  return node >= 0 ? node / kTileSize : -((kTileSize - 1 - node) / kTileSize);
}

/// Sorts tiles and removes repeated ones.
inline void sort_unique(std::vector<TileKey>& tiles) {
  std::sort(tiles.begin(), tiles.end());
  tiles.erase(std::unique(tiles.begin(), tiles.end()), tiles.end());
}

/// World position of the first node of a tile's block, halo included, [m].
inline Vec3 block_origin(const TileKey& t, double h) {
  return h * Vec3(t.x * kTileSize - kHalo, t.y * kTileSize - kHalo, t.z * kTileSize - kHalo);
}

/// Offset of node (i, j, k) of a block, each in [0, kBlockSize).
inline constexpr int block_index(int i, int j, int k) { return i + kBlockSize * (j + kBlockSize * k); }

/// The box spanned by a tile's own nodes, [m].
inline Aabb tile_box(const TileKey& t, double h) {
  const Vec3 lo = h * Vec3(t.x * kTileSize, t.y * kTileSize, t.z * kTileSize);
  return {lo, lo + Vec3::Constant(h * (kTileSize - 1))};
}

/// Inclusive range of tiles whose own nodes meet a box.
struct TileRange {
  TileKey lo, hi;
};
inline TileRange tiles_meeting(const Aabb& box, double h) {
  const auto first = [h](double x) {
    return static_cast<std::int32_t>(std::floor(std::ceil(x / h - 1e-9) / kTileSize));
  };
  const auto last = [h](double x) {
    return static_cast<std::int32_t>(std::floor(std::floor(x / h + 1e-9) / kTileSize));
  };
  return {{first(box.lo.x()), first(box.lo.y()), first(box.lo.z())},
          {last(box.hi.x()), last(box.hi.y()), last(box.hi.z())}};
}

/// The tile's eighths, 4 x 4 x 4 nodes each, as bits x + 2 y + 4 z of a byte.
using Octants = std::uint8_t;
inline constexpr Octants kAllOctants = 0xff;

/// One part's samples on a tile and its halo.
struct DensityBlock {
  /// Octants requested of the part, each with a ring of nodes around it; elsewhere rho = 0, source 0 are allowed. A
  /// part may take those back in whose own nodes it cannot touch anything; their densities are then only read in
  /// stencils.
  Octants octants = kAllOctants;
  double rho[kBlockNodes];  ///< fraction of space filled, in [0, 1]
  /// Index of the part's primitive that the node belongs to, meaningful where rho > 0; handed back to the part when its
  /// map is requested.
  std::int32_t source[kBlockNodes];
};

}  // namespace brim
