#pragma once

#include <atomic>
#include <vector>

#include "brim/core/parallel.h"
#include "brim/grid/tile.h"
#include "brim/raster/element_groups.h"
#include "brim/raster/node_span.h"
#include "brim/raster/tile_bins.h"

namespace brim {

/// A tile and its octants that may hold density at their own nodes, at least one.
struct OctantTile {
  TileKey tile;
  Octants octants;
};

/// The set of tiles that boxes meet within a region: presence of bodies made of many primitives.  Tests:
/// tests/raster/tile_cover_test.cpp
class TileCover {
 public:
  /// Clears the set. @param region  finite box; nodes outside are ignored
  void begin(const Aabb& region, double h) { begin(region, h, kHalo); }
  /// Adds every tile whose block, halo included, has a node in one of the boxes. Parallel over the boxes.
  template <class BoxOf, class GroupOf>
  void add(const BoxList<BoxOf, GroupOf>& list) {
    if (mark_.empty()) return;
    for_each_group(
        list,
        [&](const NodeSpan& group) {
          TileRange r;
          return tiles_of_box(group, h_, range_, r);
        },
        [&](std::size_t i) { mark_tiles(list.box_of(i)); });
  }
  void append_to(std::vector<TileKey>& out) const {
    for_each_marked([&](const TileKey& tile, Octants) { out.push_back(tile); });
  }

  /// begin, add and collect in one call, for several lists of boxes.
  template <class... List>
  void cover(const Aabb& region, double h, std::vector<TileKey>& out, const List&... lists) {
    begin(region, h);
    (add(lists), ...);
    append_to(out);
  }
  /// The same for octants with an own node in a box and the region.
  template <class... List>
  void cover(const Aabb& region, double h, std::vector<OctantTile>& out, const List&... lists) {
    begin(region, h, 0);
    const auto add_octants = [this](const auto& list) {
      for_each_group(
          list, [&](const NodeSpan& group) { return coarsening_ > 1 || region_.meets(group); },
          [&](std::size_t i) { mark_octants(list.box_of(i)); });
    };
    if (!mark_.empty()) (add_octants(lists), ...);
    for_each_marked([&](const TileKey& tile, Octants octants) { out.push_back({tile, octants}); });
  }

 private:
  void begin(const Aabb& region, double h, int halo);
  /// @tparam Box  Aabb [m] or NodeSpan
  template <class Box>
  void mark_tiles(const Box& box);
  void mark_octants(const Aabb& box) { mark_octants(nodes_in(box, h_, 1e-9)); }
  void mark_octants(const NodeSpan& nodes);
  void mark(std::size_t place, Octants octants) {
    // Threads may mark the same tile, in any order.
    std::atomic_ref<Octants> m(mark_[place]);
    if ((octants & ~m.load(std::memory_order_relaxed)) != 0) m.fetch_or(octants, std::memory_order_relaxed);
  }
  /// Calls f(i) for the elements of nearby groups.
  template <class List, class Near, class F>
  static void for_each_group(const List& list, const Near& near, const F& f) {
    parallel_for(
        list.groups(),
        [&](std::size_t g) {
          if (near(list.group_of(g))) list.for_group(g, f);
        },
        32);
  }
  /// Calls f(tile, octants), z slowest.
  template <class F>
  void for_each_marked(const F& f) const {
    const auto c = static_cast<std::int32_t>(coarsening_);
    for (std::size_t z = 0, i = 0; z < nz_; ++z)
      for (std::size_t y = 0; y < ny_; ++y)
        for (std::size_t x = 0; x < nx_; ++x, ++i) {
          if (mark_[i] == 0) continue;
          const TileKey first{range_.lo.x + c * static_cast<std::int32_t>(x),
                              range_.lo.y + c * static_cast<std::int32_t>(y),
                              range_.lo.z + c * static_cast<std::int32_t>(z)};
          for (std::int32_t dz = 0; dz < c && first.z + dz <= range_.hi.z; ++dz)
            for (std::int32_t dy = 0; dy < c && first.y + dy <= range_.hi.y; ++dy)
              for (std::int32_t dx = 0; dx < c && first.x + dx <= range_.hi.x; ++dx)
                f({first.x + dx, first.y + dy, first.z + dz}, mark_[i]);
        }
  }

  NodeSpan region_;  // its nodes
  double h_ = 0.0;
  TileRange range_;
  std::size_t nx_ = 0, ny_ = 0, nz_ = 0;
  std::size_t coarsening_ = 1;  // tiles per mark along each axis; above 1 only for huge regions
  std::vector<Octants> mark_;   // per tile
};

}  // namespace brim
