#include <cmath>

#include "brim/body/grid_fluid/averaged_level.h"
#include "brim/body/grid_fluid/face_map.h"
#include "brim/body/grid_fluid/grid_fluid_body.h"
#include "brim/raster/fill_tiles.h"

/// How a grid fluid shows itself to contact: density, presence, map.
namespace brim {

Vec3 GridFluidBody::mean_velocity(int, std::span<const double> v) const {
  const Vec3 p = linear_momentum(v);
  Vec3 m = Vec3::Zero();
  for (std::size_t f = 0; f < v.size(); ++f) m[static_cast<int>(f % 3)] += mass_[f];
  return p.array() / m.array().max(1e-300);
}

double GridFluidBody::relative_speed_bound(int, std::span<const double> v) const {
  const Vec3 mean = mean_velocity(0, v);
  Vec3 most = Vec3::Zero();
  for (std::size_t f = 0; f < v.size(); ++f) {
    const int a = static_cast<int>(f % 3);
    if (wet_.kind[f] != WetFaces::Kind::Dry) most[a] = std::max(most[a], std::abs(v[f] - mean[a]));
  }
  return most.norm();
}

double GridFluidBody::distance(const Vec3& x) const { return boxed_distance(model_.grid, phi_, x); }

void GridFluidBody::presence(int, double h, double w, const Aabb& region, std::vector<TileKey>& out) const {
  if (bounds_.empty()) return;
  const MacGrid& g = model_.grid;
  const Aabb where = region.intersection(bounds_.inflated(0.5 * w + h));
  if (where.empty()) return;
  const TileRange range = tiles_meeting(where.inflated(h), h);
  const std::span<const double> phi = seen();
  const double near = 0.5 * w + g.dx;  // averages may tell nearly a cell less than the distance
  for (int z = range.lo.z; z <= range.hi.z; ++z)
    for (int y = range.lo.y; y <= range.hi.y; ++y)
      for (int x = range.lo.x; x <= range.hi.x; ++x) {
        // Every cell that a node of the block may be averaged over.
        const Aabb block = tile_box({x, y, z}, h).inflated(h + 1.5 * g.dx);
        const auto place = [&](double p, int a) {
          return std::clamp(static_cast<int>(std::floor((p - g.origin[a]) / g.dx - 0.5)), 0, g.n[a] - 1);
        };
        bool found = false;
        for (int k = place(block.lo.z(), 2); k <= std::min(place(block.hi.z(), 2) + 1, g.n.z() - 1) && !found; ++k)
          for (int j = place(block.lo.y(), 1); j <= std::min(place(block.hi.y(), 1) + 1, g.n.y() - 1) && !found; ++j)
            for (int i = place(block.lo.x(), 0); i <= std::min(place(block.hi.x(), 0) + 1, g.n.x() - 1) && !found; ++i)
              found = phi[g.cell(i, j, k)] < near;
        if (found) out.push_back({x, y, z});
      }
}

void GridFluidBody::rasterize(int, double h, double w, std::span<const TileKey> tiles,
                              std::span<DensityBlock> out) const {
  fill_tiles([this, w](const Vec3& r) { return averaged_distance(model_.grid, seen(), r, w); }, tiles, h, w, out);
}

void GridFluidBody::make_map(int, std::span<const Vec3> points, std::span<const std::int32_t>,
                             std::unique_ptr<Map>& map) const {
  if (!map) map = std::make_unique<FaceMap>();
  static_cast<FaceMap&>(*map).reset(
      model_.grid, wet_, phi_, [this](int cell) { return touched_motion(cell); }, points);
}

void GridFluidBody::display_velocities(std::span<const double> v, std::span<const Vec3f> x, std::span<Vec3f> u) const {
  std::vector<Vec3> points, velocities(x.size());
  for (const Vec3f& p : x) points.push_back(p.cast<double>());
  FaceMap map;
  map.reset(model_.grid, wet_, phi_, SurfaceMotion::Follows, points);
  map.apply(v, velocities);
  for (std::size_t i = 0; i < u.size(); ++i) u[i] = velocities[i].cast<float>();
}

}  // namespace brim
