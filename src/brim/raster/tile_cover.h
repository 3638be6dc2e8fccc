#pragma once

#include <vector>

#include "brim/core/parallel.h"
#include "brim/grid/tile.h"

namespace brim {

/// The set of tiles that boxes touch within a region; the presence of bodies made of many primitives.
class TileCover {
 public:
  /// Clears the set. @param region  finite box; nodes outside of it do not count
  void begin(const Aabb& region, double h);
  /// Adds every tile whose block, halo included, has a node in box_of(i), i in [0, n). Parallel over i.
  template <class BoxOf>
  void add(std::size_t n, const BoxOf& box_of) {
    parallel_for(
        n, [&](std::size_t i) { mark(box_of(i)); }, 1024);
  }
  void append_to(std::vector<TileKey>& out) const;

 private:
  void mark(const Aabb& box);

  double h_ = 0.0;
  TileRange range_;
  std::size_t nx_ = 0, ny_ = 0, nz_ = 0;
  std::size_t coarsening_ = 1;  // tiles per mark along each axis; above 1 only for huge regions
  std::vector<unsigned char> mark_;
};

}  // namespace brim
