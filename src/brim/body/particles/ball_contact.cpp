#include "brim/body/particles/ball_contact.h"

#include <algorithm>

#include "brim/map/balls_map.h"

namespace brim {

BallContact::BallContact(std::vector<double> radius)
    : radius_(std::move(radius)), largest_(*std::max_element(radius_.begin(), radius_.end())) {}

void BallContact::presence(std::span<const Vec3> x, double h, double w, const Aabb& region,
                           std::vector<TileKey>& out) const {
  auto workspace = workspace_.borrow();
  presence_points(x, radius_, h, w, region, out, *workspace);
}

void BallContact::octant_presence(std::span<const Vec3> x, double h, double w, const Aabb& region,
                                  std::vector<OctantTile>& out) const {
  auto workspace = workspace_.borrow();
  presence_points(x, radius_, h, w, region, out, *workspace);
}

void BallContact::rasterize(std::span<const Vec3> x, double h, double w, std::span<const TileKey> tiles,
                            std::span<DensityBlock> out) const {
  auto workspace = workspace_.borrow();
  raster_points(x, radius_, tiles, h, w, out, *workspace);
}

void BallContact::make_map(std::span<const Vec3> x, std::span<const Vec3> points, std::span<const std::int32_t> sources,
                           std::unique_ptr<Map>& map) const {
  reuse_map<BallsMap>(map).reset(x, points, sources);
}

}  // namespace brim
