#include "brim/body/particles/sheet_contact.h"

#include "brim/core/error.h"
#include "brim/map/shell_weights.h"

namespace brim {

std::unique_ptr<const ParticleContact> SheetContact::piece(std::span<const std::int32_t> elements) const {
  std::vector<Triangle> own;
  for (const std::int32_t e : elements) own.push_back(triangles_[e]);
  return std::make_unique<SheetContact>(std::move(own), thickness_);
}

void SheetContact::presence(std::span<const Vec3> x, double h, double w, const Aabb& region,
                            std::vector<TileKey>& out) const {
  auto workspace = workspace_.borrow();
  presence_triangles(x, triangles_, thickness_, h, w, region, out, *workspace);
}

void SheetContact::octant_presence(std::span<const Vec3> x, double h, double w, const Aabb& region,
                                   std::vector<OctantTile>& out) const {
  auto workspace = workspace_.borrow();
  presence_triangles(x, triangles_, thickness_, h, w, region, out, *workspace);
}

void SheetContact::rasterize(std::span<const Vec3> x, double h, double w, std::span<const TileKey> tiles,
                             std::span<DensityBlock> out) const {
  auto workspace = workspace_.borrow();
  raster_triangles(x, triangles_, thickness_, tiles, h, w, out, *workspace);
}

void SheetContact::make_map(std::span<const Vec3> x, std::span<const Vec3> points,
                            std::span<const std::int32_t> sources, std::unique_ptr<Map>& map) const {
  BRIM_CHECK(points.size(), ==, sources.size());
  reuse_map<ShellWeightsMap>(map).build(patches_, points, sources, x);
}

}  // namespace brim
