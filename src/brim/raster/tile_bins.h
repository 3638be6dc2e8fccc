#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "brim/core/parallel.h"
#include "brim/grid/tile.h"
#include "brim/raster/element_groups.h"
#include "brim/raster/node_span.h"

namespace brim {

/// Looks up tiles in a list of tiles.
class TileIndex {
 public:
  /// @param tiles  distinct, in any order
  void build(std::span<const TileKey> tiles);
  /// Smallest range that contains all tiles; lo > hi when there are none.
  const TileRange& range() const { return range_; }
  /// Index in the list, or −1.
  std::int32_t find(std::int32_t x, std::int32_t y, std::int32_t z) const;
  /// Calls f(index) for each listed tile of a range. Cost: the smaller of the range and the list.
  template <class F>
  void for_each_in(const TileRange& r, const F& f) const {
    const double volume = (double(r.hi.x) - r.lo.x + 1) * (double(r.hi.y) - r.lo.y + 1) * (double(r.hi.z) - r.lo.z + 1);
    if (volume > static_cast<double>(tiles_.size())) {
      for (std::size_t i = 0; i < tiles_.size(); ++i) {
        const TileKey& t = tiles_[i];
        if (t.x >= r.lo.x && t.x <= r.hi.x && t.y >= r.lo.y && t.y <= r.hi.y && t.z >= r.lo.z && t.z <= r.hi.z)
          f(static_cast<std::int32_t>(i));
      }
      return;
    }
    for (std::int32_t z = r.lo.z; z <= r.hi.z; ++z)
      for (std::int32_t y = r.lo.y; y <= r.hi.y; ++y)
        for (std::int32_t x = r.lo.x; x <= r.hi.x; ++x)
          if (const std::int32_t t = find(x, y, z); t >= 0) f(t);
  }

 private:
  std::vector<TileKey> tiles_;
  TileRange range_;
  std::int64_t nx_ = 0, ny_ = 0;
  bool dense_ = false;
  std::vector<std::int32_t> slot_;                        // dense: index + 1 by position in the range, else 0
  std::vector<std::pair<TileKey, std::int32_t>> sorted_;  // otherwise
};

/// Range of tiles whose block, halo included, has a node in the box; clipped to `limit`. False when empty (also for
/// boxes with NaN or infinity).
bool tiles_of_box(const Aabb& box, double h, const TileRange& limit, TileRange& out);

/// The same for tiles whose block has one of the nodes.
inline bool tiles_of_box(const NodeSpan& nodes, double, const TileRange& limit, TileRange& out) {
  static_assert(kTileSize == 8);
  out = {{std::max((nodes.lo[0] - kHalo) >> 3, limit.lo.x), std::max((nodes.lo[1] - kHalo) >> 3, limit.lo.y),
          std::max((nodes.lo[2] - kHalo) >> 3, limit.lo.z)},
         {std::min((nodes.hi[0] + kHalo) >> 3, limit.hi.x), std::min((nodes.hi[1] + kHalo) >> 3, limit.hi.y),
          std::min((nodes.hi[2] + kHalo) >> 3, limit.hi.z)}};
  return !nodes.empty() && out.lo.x <= out.hi.x && out.lo.y <= out.hi.y && out.lo.z <= out.hi.z;
}

/// Nodes of a tile's block in a box: inclusive local ranges, clipped to the block and to the span of the wanted
/// octants.
struct NodeRange {
  int lo[3], hi[3];
  bool empty() const { return lo[0] > hi[0] || lo[1] > hi[1] || lo[2] > hi[2]; }
};
/// The nodes spanned by the wanted octants with their rings.
inline NodeRange wanted_nodes(Octants wanted) {
  // Octants of the lower half along each axis; the complement is the upper half.
  constexpr Octants kLower[3] = {0x55, 0x33, 0x0f};
  constexpr int kHalf = kTileSize / 2;
  NodeRange r;
  for (int a = 0; a < 3; ++a) {
    r.lo[a] = wanted & kLower[a] ? 0 : kHalf;
    r.hi[a] = wanted & ~kLower[a] ? kBlockSize - 1 : kHalf + 2 * kHalo - 1;
  }
  return r;
}
NodeRange nodes_in_box(const Aabb& box, const Vec3& origin, double h, Octants wanted);

/// For each given tile, the primitives whose box meets its block, by ascending index. Work and memory are proportional
/// to the primitives near the given tiles. Same result for any number of threads.
class TileBins {
 public:
  /// @param wanted  nodes of the tiles that are needed: primitives without any of them may be left out
  template <class BoxOf, class GroupOf>
  void build(const TileIndex& index, std::size_t tile_count, double h, const BoxList<BoxOf, GroupOf>& list,
             const NodeSpan& wanted = NodeSpan::all()) {
    const std::size_t blocks = (list.groups() + kGroups - 1) / kGroups;
    if (pairs_.size() < blocks) pairs_.resize(blocks);
    parallel_for(blocks, [&](std::size_t b) {
      auto& pairs = pairs_[b];
      pairs.clear();
      for (std::size_t g = b * kGroups; g < std::min(list.groups(), (b + 1) * kGroups); ++g) {
        if (!wanted.meets(list.group_of(g))) continue;
        list.for_group(g, [&](std::size_t i) {
          TileRange r;
          if (!tiles_of_box(list.box_of(i), h, index.range(), r)) return;
          index.for_each_in(r, [&](std::int32_t t) { pairs.push_back({t, static_cast<std::int32_t>(i)}); });
        });
      }
    });
    sort(blocks, tile_count);
  }

  std::span<const std::int32_t> of(std::size_t tile) const {
    return std::span(items_).subspan(first_[tile], static_cast<std::size_t>(first_[tile + 1] - first_[tile]));
  }

 private:
  struct Pair {
    std::int32_t tile, primitive;
  };
  static constexpr std::size_t kGroups = 32;  // in a block
  void sort(std::size_t blocks, std::size_t tile_count);

  std::vector<std::vector<Pair>> pairs_;  // per block of primitives
  std::vector<std::int32_t> first_, next_, items_;
};

}  // namespace brim
