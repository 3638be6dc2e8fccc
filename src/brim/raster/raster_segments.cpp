#include "brim/raster/raster_segments.h"

#include "brim/raster/capsule_splat.h"

namespace brim {

namespace {

auto capsules(std::span<const Vec3> x, std::span<const std::array<std::int32_t, 2>> segments,
              std::span<const double> radius) {
  BRIM_CHECK(radius.size() == 1 || radius.size() == segments.size(), ==, true);
  const std::size_t stride = radius.size() == 1 ? 0 : 1;
  return [=](std::size_t i) { return Capsule{x[segments[i][0]], x[segments[i][1]], radius[stride * i]}; };
}

}  // namespace

void raster_segments(std::span<const Vec3> x, std::span<const std::array<std::int32_t, 2>> segments,
                     std::span<const double> radius, std::span<const TileKey> tiles, double h, double w,
                     std::span<DensityBlock> out, RasterWorkspace& workspace) {
  raster_capsules(segments.size(), capsules(x, segments, radius), tiles, h, w, out, workspace);
}

void presence_segments(std::span<const Vec3> x, std::span<const std::array<std::int32_t, 2>> segments,
                       std::span<const double> radius, double h, double w, const Aabb& region,
                       std::vector<TileKey>& out, RasterWorkspace& workspace) {
  presence_capsules(segments.size(), capsules(x, segments, radius), h, w, region, out, workspace);
}

void presence_segments(std::span<const Vec3> x, std::span<const std::array<std::int32_t, 2>> segments,
                       std::span<const double> radius, double h, double w, const Aabb& region,
                       std::vector<OctantTile>& out, RasterWorkspace& workspace) {
  presence_capsules(segments.size(), capsules(x, segments, radius), h, w, region, out, workspace);
}

}  // namespace brim
