#pragma once

#include <functional>
#include <span>
#include <vector>

#include "brim/raster/shape.h"
#include "support/detect.h"

namespace brim::testing {

/// Two parts on all tiles where both may be, and their contacts.
struct Touching {
  /// Writes the density of a part on the given tiles.
  using Rasterize = std::function<void(std::span<const TileKey>, std::span<DensityBlock>)>;

  std::vector<TileKey> tiles;
  std::vector<DensityBlock> a, b;
  ContactSet contacts;

  /// @param both  box that holds all matter of both, without ramp
  Touching(const Rasterize& rasterize_a, const Rasterize& rasterize_b, const Aabb& both, double h, double w,
           double margin = 0.0) {
    const TileRange r = tiles_meeting(both.inflated(w + h), h);
    for (int z = r.lo.z; z <= r.hi.z; ++z)
      for (int y = r.lo.y; y <= r.hi.y; ++y)
        for (int x = r.lo.x; x <= r.hi.x; ++x) tiles.push_back({x, y, z});
    a.resize(tiles.size()), b.resize(tiles.size());
    rasterize_a(tiles, a), rasterize_b(tiles, b);
    std::vector<PairTile> pair_tiles;
    for (std::size_t t = 0; t < tiles.size(); ++t) pair_tiles.push_back({0, tiles[t], &a[t], &b[t]});
    contacts.pairs.push_back({0, 1, h, w, margin, 0, 0});
    detect(pair_tiles, contacts);
  }

  Touching(const Shape& shape_a, const Pose& pose_a, const Shape& shape_b, const Pose& pose_b, double h, double w,
           double margin = 0.0)
      : Touching(fill(shape_a, pose_a, h, w), fill(shape_b, pose_b, h, w),
                 shape_a.placed_bounds(pose_a).intersection(shape_b.placed_bounds(pose_b)), h, w, margin) {}

  static Rasterize fill(const Shape& shape, const Pose& pose, double h, double w) {
    return [&shape, pose, h, w](std::span<const TileKey> tiles, std::span<DensityBlock> out) {
      for (std::size_t t = 0; t < tiles.size(); ++t) shape.fill(pose, tiles[t], h, w, out[t]);
    };
  }
};

/// Pose of a half-space whose outward normal is n, through the point x.
inline Pose plane_pose(const Vec3& n, const Vec3& x) {
  return {Quat::FromTwoVectors(Vec3(0, 0, 1), n).toRotationMatrix(), x};
}

}  // namespace brim::testing
