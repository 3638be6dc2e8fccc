#pragma once

#include <algorithm>
#include <span>

#include "brim/core/parallel.h"
#include "brim/grid/tile.h"
#include "brim/math/ramp.h"

namespace brim {

/// Writes the density of a solid given by a distance in world coordinates at every node of every tile; source 0.
///   rho(r) = ramp(distance(r), w)
/// For distances without a bound on their change; rigid shapes recognise full and empty tiles (fill_block).
/// @param distance  Vec3 [m] -> [m], negative inside; called from several threads
/// @param h, w      [m] grid step, ramp width
/// Same bits for any number of threads.  Tests: tests/raster/fill_tiles_test.cpp
template <class Distance>
void fill_tiles(const Distance& distance, std::span<const TileKey> tiles, double h, double w,
                std::span<DensityBlock> out) {
  parallel_for(tiles.size(), [&](std::size_t t) {
    const Vec3 origin = block_origin(tiles[t], h);
    std::fill(std::begin(out[t].source), std::end(out[t].source), 0);
    double* rho = out[t].rho;
    for (int k = 0; k < kBlockSize; ++k)
      for (int j = 0; j < kBlockSize; ++j)
        for (int i = 0; i < kBlockSize; ++i) *rho++ = ramp(distance(origin + h * Vec3(i, j, k)), w);
  });
}

}  // namespace brim
