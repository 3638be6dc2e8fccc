#pragma once

#include <span>
#include <vector>

#include "brim/grid/tile.h"
#include "brim/mesh/tri_mesh.h"
#include "brim/raster/element_groups.h"
#include "brim/raster/node_span.h"
#include "brim/raster/splat_reach.h"
#include "brim/raster/tile_bins.h"
#include "brim/raster/tile_cover.h"

namespace brim {

/// Groups by which raster_tets skips elements far from the tiles.
struct TetGroups {
  ElementGroups tets, surface;
};

/// A solid of tetrahedra at its current positions. The spans must outlive the call.
struct TetSolid {
  std::span<const Vec3> x;              ///< nodes, [m]
  std::span<const Tetrahedron> tets;    ///< shape (ne, 4); may be inverted by deformation
  std::span<const Triangle> surface;    ///< boundary triangles, indices into x
  std::span<const std::int32_t> owner;  ///< tetrahedron behind each boundary triangle
  const TetGroups* groups = nullptr;    ///< of tets and surface; null: all elements are tested
};

/// Scratch memory, kept by the caller between calls.
struct TetRasterWorkspace {
  TileIndex index;
  VertexNodes nodes;
  TileBins tets, surface;
  SplatReach reach;
  TileCover cover;
};

/// Writes the density of a solid of tetrahedra: the band method.
///   rho(r) = ramp(s d, w),  d: distance to the boundary triangles, s = −1 inside of any tetrahedron, +1 outside
/// The source is the tetrahedron that contains the node (lowest index), or outside the owner of the nearest boundary
/// triangle; its barycentric weights, extrapolated there, have Σ w = 1 and Σ w x = r.
/// Where a solid passes through itself its inner boundary lowers the density; tetrahedra of zero volume contain no
/// node.
/// Cost: O(tetrahedra and boundary triangles near the tiles). Same bits for any number of threads.
/// @param h    [m]  grid step
/// @param w    [m]  ramp width
/// @param out  one block per tile, overwritten; source −1 where rho = 0
/// Tests: tests/raster/raster_tets_test.cpp
void raster_tets(const TetSolid& solid, std::span<const TileKey> tiles, double h, double w, std::span<DensityBlock> out,
                 TetRasterWorkspace& workspace);

/// Tiles whose block, halo included, may hold density of the solid, within a region; appended to out, each once.
void presence_tets(const TetSolid& solid, double h, double w, const Aabb& region, std::vector<TileKey>& out,
                   TetRasterWorkspace& workspace);
/// The same for octants with own nodes that may hold density.
void presence_tets(const TetSolid& solid, double h, double w, const Aabb& region, std::vector<OctantTile>& out,
                   TetRasterWorkspace& workspace);

/// Default bound of Σ|w| for extrapolated weights in a tetrahedron.
constexpr double kMaxTetWeight = 8.0;

/// Barycentric weights of r in a tetrahedron, Σ = 1, Σ w x = r, extrapolated linearly outside. If Σ|w| would exceed
/// `max_weight` (slivers, far points), those of the closest point of its faces: Σ = 1 and all w >= 0, but Σ w x is then
/// only near r.
std::array<double, 4> tet_weights(const Vec3& r, const std::array<Vec3, 4>& x, double max_weight = kMaxTetWeight);

/// Barycentric weights of r without that bound: not finite for zero volume.
inline std::array<double, 4> linear_weights(const Vec3& r, const std::array<Vec3, 4>& x) {
  const Vec3 e1 = x[1] - x[0], e2 = x[2] - x[0], e3 = x[3] - x[0], d = r - x[0];
  const Vec3 c1 = e2.cross(e3), side = e1.cross(d);
  const double inverse = 1.0 / e1.dot(c1);
  const double b1 = inverse * d.dot(c1), b2 = inverse * e3.dot(side), b3 = -inverse * e2.dot(side);
  return {1.0 - (b1 + b2 + b3), b1, b2, b3};
}
/// Σ|w| of weights.
inline double sum_of_sizes(const std::array<double, 4>& w) {
  return std::abs(w[0]) + std::abs(w[1]) + std::abs(w[2]) + std::abs(w[3]);
}

/// Σ|w| of r in a tetrahedron without the bound; infinite for zero volume.
double tet_weight_sum(const Vec3& r, const std::array<Vec3, 4>& x);

}  // namespace brim
