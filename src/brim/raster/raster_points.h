#pragma once

#include <span>
#include <vector>

#include "brim/grid/tile.h"
#include "brim/raster/raster_triangles.h"

namespace brim {

/// Writes the density of a union of balls.
///   rho(r) = ramp(d, w),  d = min over points of (|r − x_i| − R_i)
/// The source is the point that gives the minimum (of equals the lowest index).
/// Cost: O(points near the tiles). Same bits for any number of threads.
/// @param x       centres, [m]
/// @param radius  [m]  one per point, or a single one for all
/// @param out     one block per tile, overwritten; source −1 where rho = 0
/// Tests: tests/raster/raster_capsules_test.cpp
void raster_points(std::span<const Vec3> x, std::span<const double> radius, std::span<const TileKey> tiles, double h,
                   double w, std::span<DensityBlock> out, RasterWorkspace& workspace);

/// Tiles whose block, halo included, may hold density, within a region; appended to out, each once.
void presence_points(std::span<const Vec3> x, std::span<const double> radius, double h, double w, const Aabb& region,
                     std::vector<TileKey>& out, RasterWorkspace& workspace);
/// The same for octants with own nodes that may hold density.
void presence_points(std::span<const Vec3> x, std::span<const double> radius, double h, double w, const Aabb& region,
                     std::vector<OctantTile>& out, RasterWorkspace& workspace);

}  // namespace brim
