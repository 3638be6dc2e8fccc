#pragma once

#include <vector>

#include "brim/contact/contact_set.h"
#include "brim/raster/shape.h"

namespace brim::testing {

/// Two placed shapes on all tiles where both may be, and their contacts.
struct Touching {
  std::vector<TileKey> tiles;
  std::vector<DensityBlock> a, b;
  ContactSet contacts;

  Touching(const Shape& shape_a, const Pose& pose_a, const Shape& shape_b, const Pose& pose_b, double h, double w,
           double margin = 0.0) {
    const Aabb region = shape_a.placed_bounds(pose_a).intersection(shape_b.placed_bounds(pose_b)).inflated(w + h);
    const TileRange r = tiles_meeting(region, h);
    for (int z = r.lo.z; z <= r.hi.z; ++z)
      for (int y = r.lo.y; y <= r.hi.y; ++y)
        for (int x = r.lo.x; x <= r.hi.x; ++x) tiles.push_back({x, y, z});
    a.resize(tiles.size()), b.resize(tiles.size());
    std::vector<PairTile> pair_tiles;
    for (std::size_t t = 0; t < tiles.size(); ++t) {
      shape_a.fill(pose_a, tiles[t], h, w, a[t]);
      shape_b.fill(pose_b, tiles[t], h, w, b[t]);
      pair_tiles.push_back({0, tiles[t], &a[t], &b[t]});
    }
    contacts.pairs.push_back({0, 1, h, w, margin, 0, 0});
    detect(pair_tiles, contacts);
  }
};

/// Pose of a half-space whose outward normal is n, through the point x.
inline Pose plane_pose(const Vec3& n, const Vec3& x) {
  return {Quat::FromTwoVectors(Vec3(0, 0, 1), n).toRotationMatrix(), x};
}

}  // namespace brim::testing
