#include "brim/body/particles/tet_contact.h"

#include <algorithm>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/map/point_weights.h"
#include "brim/mesh/topology.h"

namespace brim {

TetContact::TetContact(const TetMesh& mesh) : tets_(mesh.tets), fallback_(tets_) {
  TetSurface surface = tet_surface(mesh);
  surface_ = std::move(surface.triangles);
  owner_ = std::move(surface.owner);
  groups_.tets.build(std::span<const Tetrahedron>(tets_));
  groups_.surface.build(std::span<const Triangle>(surface_));
}

void TetContact::presence(std::span<const Vec3> x, double h, double w, const Aabb& region,
                          std::vector<TileKey>& out) const {
  auto workspace = workspace_.borrow();
  presence_tets(solid(x), h, w, region, out, *workspace);
}

void TetContact::octant_presence(std::span<const Vec3> x, double h, double w, const Aabb& region,
                                 std::vector<OctantTile>& out) const {
  auto workspace = workspace_.borrow();
  presence_tets(solid(x), h, w, region, out, *workspace);
}

void TetContact::rasterize(std::span<const Vec3> x, double h, double w, std::span<const TileKey> tiles,
                           std::span<DensityBlock> out) const {
  auto workspace = workspace_.borrow();
  raster_tets(solid(x), tiles, h, w, out, *workspace);
}

void TetContact::make_map(std::span<const Vec3> x, std::span<const Vec3> points, std::span<const std::int32_t> sources,
                          std::unique_ptr<Map>& map) const {
  BRIM_CHECK(points.size(), ==, sources.size());
  auto& weights = reuse_map<PointWeightsMap>(map);
  weights.reset(x.size(), points.size(), 4);
  parallel_blocks(points.size(), 512, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      const auto corners = [&](const Tetrahedron& c) { return std::array{x[c[0]], x[c[1]], x[c[2]], x[c[3]]}; };
      // Most points lie in, or near, their own tetrahedron.
      const Tetrahedron* t = &tets_[sources[p]];
      std::array<double, 4> w = linear_weights(points[p], corners(*t));
      if (!(sum_of_sizes(w) <= kMaxTetWeight)) {
        t = &tets_[fallback_.choose(tets_, sources[p], kMaxTetWeight,
                                    [&](const Tetrahedron& c) { return tet_weight_sum(points[p], corners(c)); })];
        w = tet_weights(points[p], corners(*t));
      }
      const auto row = weights.row(p);
      std::copy(t->begin(), t->end(), row.particle.begin());
      std::copy(w.begin(), w.end(), row.weight.begin());
    }
  });
  weights.finish();
}

PartInfo TetContact::part_info(std::span<const Vec3> x, double volume, double density) const {
  // Two voxels per boundary edge resolve the faces; the column behind the contact is at most the longest extent.
  double edge = 0.0, area = 0.0;
  for (const Triangle& t : surface_) {
    for (int i = 0; i < 3; ++i) edge += (x[t[i]] - x[t[(i + 1) % 3]]).norm();
    area += 0.5 * (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).norm();
  }
  const Vec3 extent = bounds(x).extent();
  PartInfo part;
  part.voxel_size = 0.5 * edge / (3.0 * static_cast<double>(surface_.size()));
  part.areal_mass = density * volume * extent.maxCoeff() / extent.prod();
  part.thickness = std::min(extent.minCoeff(), 6.0 * volume / area);
  part.width = width_of(volume, part.thickness, bounds(x));
  return part;
}

}  // namespace brim
