#pragma once

#include <span>
#include <vector>

#include "brim/grid/tile.h"
#include "brim/mesh/tri_mesh.h"
#include "brim/raster/splat_reach.h"
#include "brim/raster/tile_bins.h"
#include "brim/raster/tile_cover.h"

namespace brim {

/// Scratch memory for rasterizing one list of primitives, kept by the caller between calls.
struct RasterWorkspace {
  TileIndex index;
  TileBins bins;
  SplatReach reach;
  TileCover cover;
};

/// Writes the density of a sheet: everything within half the thickness of its triangles.
///   rho(r) = ramp(d − t/2, w),  d: distance to the nearest triangle
/// The source is the nearest triangle (of equals the lowest index). A sheet thinner than the ramp never reaches
/// rho = 1: at its middle rho = ramp(−t/2, w), 0.93 for t = 2h and w = 3h.
/// Cost: O(triangles near the tiles). Same bits for any number of threads.
/// @param x          positions, [m]
/// @param thickness  [m]  full thickness t, >= 0
/// @param out        one block per tile, overwritten; source −1 where rho = 0
/// Tests: tests/raster/raster_triangles_test.cpp
void raster_triangles(std::span<const Vec3> x, std::span<const Triangle> triangles, double thickness,
                      std::span<const TileKey> tiles, double h, double w, std::span<DensityBlock> out,
                      RasterWorkspace& workspace);

/// Tiles whose block, halo included, may hold density of the sheet, within a region; appended to out, each once.
void presence_triangles(std::span<const Vec3> x, std::span<const Triangle> triangles, double thickness, double h,
                        double w, const Aabb& region, std::vector<TileKey>& out, RasterWorkspace& workspace);
/// The same for octants with own nodes that may hold density.
void presence_triangles(std::span<const Vec3> x, std::span<const Triangle> triangles, double thickness, double h,
                        double w, const Aabb& region, std::vector<OctantTile>& out, RasterWorkspace& workspace);

}  // namespace brim
