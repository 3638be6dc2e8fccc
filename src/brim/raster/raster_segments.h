#pragma once

#include <array>
#include <span>
#include <vector>

#include "brim/grid/tile.h"
#include "brim/raster/raster_triangles.h"

namespace brim {

/// Writes the density of capsules: everything within a radius of a segment (rods, ropes, hair, skeletons of
/// mass-spring bodies).
///   rho(r) = ramp(d, w),  d = min over segments of (|r − segment| − R_i)
/// The source is the segment that gives the minimum (of equals the lowest index).
/// Cost: O(segments near the tiles). Same bits for any number of threads.
/// @param x         positions, [m]
/// @param segments  pairs of indices into x; equal indices make a sphere
/// @param radius    [m]  one per segment, or a single one for all
/// @param out       one block per tile, overwritten; source −1 where rho = 0
/// Tests: tests/raster/raster_capsules_test.cpp
void raster_segments(std::span<const Vec3> x, std::span<const std::array<std::int32_t, 2>> segments,
                     std::span<const double> radius, std::span<const TileKey> tiles, double h, double w,
                     std::span<DensityBlock> out, RasterWorkspace& workspace);

/// Tiles whose block, halo included, may hold density, within a region; appended to out, each once.
void presence_segments(std::span<const Vec3> x, std::span<const std::array<std::int32_t, 2>> segments,
                       std::span<const double> radius, double h, double w, const Aabb& region,
                       std::vector<TileKey>& out, RasterWorkspace& workspace);
/// The same for octants with own nodes that may hold density.
void presence_segments(std::span<const Vec3> x, std::span<const std::array<std::int32_t, 2>> segments,
                       std::span<const double> radius, double h, double w, const Aabb& region,
                       std::vector<OctantTile>& out, RasterWorkspace& workspace);

}  // namespace brim
