#include "brim/body/particles/line_contact.h"

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/map/line_weights.h"

namespace brim {

std::unique_ptr<const ParticleContact> LineContact::piece(std::span<const std::int32_t> elements) const {
  std::vector<Segment> own;
  for (const std::int32_t e : elements) own.push_back(segments_[e]);
  return std::make_unique<LineContact>(std::move(own), radius_);
}

void LineContact::presence(std::span<const Vec3> x, double h, double w, const Aabb& region,
                           std::vector<TileKey>& out) const {
  auto workspace = workspace_.borrow();
  presence_segments(x, segments_, {&radius_, 1}, h, w, region, out, *workspace);
}

void LineContact::octant_presence(std::span<const Vec3> x, double h, double w, const Aabb& region,
                                  std::vector<OctantTile>& out) const {
  auto workspace = workspace_.borrow();
  presence_segments(x, segments_, {&radius_, 1}, h, w, region, out, *workspace);
}

void LineContact::rasterize(std::span<const Vec3> x, double h, double w, std::span<const TileKey> tiles,
                            std::span<DensityBlock> out) const {
  auto workspace = workspace_.borrow();
  raster_segments(x, segments_, {&radius_, 1}, tiles, h, w, out, *workspace);
}

void LineContact::make_map(std::span<const Vec3> x, std::span<const Vec3> points, std::span<const std::int32_t> sources,
                           std::unique_ptr<Map>& map) const {
  BRIM_CHECK(points.size(), ==, sources.size());
  auto& weights = reuse_map<LineWeightsMap>(map);
  weights.reset(x.size(), points.size());
  parallel_blocks(points.size(), 512, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) weights.set(p, points[p], segments_[sources[p]], x);
  });
  weights.finish();
}

}  // namespace brim
