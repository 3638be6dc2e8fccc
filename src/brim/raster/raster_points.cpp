#include "brim/raster/raster_points.h"

#include "brim/raster/capsule_splat.h"

namespace brim {

namespace {

auto balls(std::span<const Vec3> x, std::span<const double> radius) {
  BRIM_CHECK(radius.size() == 1 || radius.size() == x.size(), ==, true);
  const std::size_t stride = radius.size() == 1 ? 0 : 1;
  return [=](std::size_t i) { return Capsule{x[i], x[i], radius[stride * i]}; };
}

}  // namespace

void raster_points(std::span<const Vec3> x, std::span<const double> radius, std::span<const TileKey> tiles, double h,
                   double w, std::span<DensityBlock> out, RasterWorkspace& workspace) {
  raster_capsules(x.size(), balls(x, radius), tiles, h, w, out, workspace);
}

void presence_points(std::span<const Vec3> x, std::span<const double> radius, double h, double w, const Aabb& region,
                     std::vector<TileKey>& out, RasterWorkspace& workspace) {
  presence_capsules(x.size(), balls(x, radius), h, w, region, out, workspace);
}

void presence_points(std::span<const Vec3> x, std::span<const double> radius, double h, double w, const Aabb& region,
                     std::vector<OctantTile>& out, RasterWorkspace& workspace) {
  presence_capsules(x.size(), balls(x, radius), h, w, region, out, workspace);
}

}  // namespace brim
