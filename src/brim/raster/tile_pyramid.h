#pragma once

#include <array>
#include <span>
#include <vector>

#include "brim/grid/tile.h"

namespace brim {

/// Weights of the binomial filter between two levels, along each axis: (1, 6, 15, 20, 15, 6, 1)/64. With its variance,
/// 1.5 steps², a ramp of 3 steps stays 3.1 to 3.2 steps wide at every coarser level: (0.45 + 1.5)/4 = 0.49, where the
/// ramp's own slope has 9/20.
inline constexpr std::array<double, 7> kBinomial = {1.0 / 64,  6.0 / 64, 15.0 / 64, 20.0 / 64,
                                                    15.0 / 64, 6.0 / 64, 1.0 / 64};

/// The tiles of half the step that reduce_tiles reads for the given tiles: sorted, each once.
std::vector<TileKey> tiles_below(std::span<const TileKey> tiles);

/// A level of a pyramid of densities (paper, section 4.1): node i of a tile is the binomial mean about node 2 i of the
/// level below. Its source is that of this node or, if that is empty, of the fullest node in the mean.
/// @param below   tiles of half the step, sorted; missing ones count as empty
/// @param blocks  of the tiles below  @param out  shape (tiles); octants are left unchanged
/// Same bits for any number of threads.  Tests: tests/raster/tile_pyramid_test.cpp
void reduce_tiles(std::span<const TileKey> below, std::span<const DensityBlock> blocks, std::span<const TileKey> tiles,
                  std::span<DensityBlock> out);

}  // namespace brim
