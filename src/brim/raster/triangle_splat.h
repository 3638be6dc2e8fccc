#pragma once

#include <cstdint>
#include <span>

#include "brim/mesh/tri_mesh.h"
#include "brim/raster/block_rows.h"
#include "brim/raster/splat_reach.h"

namespace brim {

/// Nearest triangle of each node of a block: lowers scratch.value, the squared distance in voxels, and sets
/// scratch.nearest where a triangle is closer than the present value; of equals the first stays. Eight nodes at a time
/// in single precision: error of a distance d at most 2e-6 voxels and 2e-7 of the triangle's longest edge.
/// @param x          positions, [m]
/// @param triangles  all of them; which: indices of those to splat, in order
/// @param name       number of each triangle in scratch.nearest; its index when empty
/// @param reach      bounds the nodes for which a triangle may be the nearest
/// @param origin     [m] first node of the block  @param h  [m] step
/// @param wanted     the needed octants of the block
/// Tests: tests/raster/raster_triangles_test.cpp, tests/raster/raster_tets_test.cpp
void splat_triangles(std::span<const Vec3> x, std::span<const Triangle> triangles, std::span<const std::int32_t> which,
                     std::span<const std::int32_t> name, const SplatReach& reach, const Vec3& origin, double h,
                     Octants wanted, BlockScratch& scratch);

}  // namespace brim
