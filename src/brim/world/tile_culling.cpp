#include "brim/world/tile_culling.h"

#include <cmath>

#include "brim/contact/cube_contacts.h"

namespace brim {

Octants octants_with_room(const BoundedPart& a, const BoundedPart& b, const ContactPair& pair, const TileKey& tile) {
  const double h = pair.h, gap = widest_gap(pair.margin) * pair.w;
  const BoundedPart& known = a.body != nullptr ? a : b;
  const bool both = a.body != nullptr && b.body != nullptr;
  if (known.body == nullptr) return kAllOctants;
  const auto ruled_out = [&](const Vec3& lo, int nodes, bool& deep) {
    const double half = 0.5 * (nodes - 1) * h, radius = std::sqrt(3.0) * half + 1e-9 * h;
    const Vec3 center = lo + Vec3::Constant(half);
    if (!both) {
      const double d = known.body->distance_bound(known.part, center);
      deep = !(d > 0.5 * pair.w);
      return d > 0.5 * pair.w + radius;
    }
    const double sum = a.body->distance_bound(a.part, center) + b.body->distance_bound(b.part, center);
    deep = !(sum > gap);
    return sum > gap + 2.0 * radius;
  };
  const auto part_of = [h](const Vec3& lo, int nodes, int i) {
    return Vec3(lo + 0.5 * nodes * h * Vec3(i & 1, (i >> 1) & 1, i >> 2));
  };
  bool deep = false;
  const Vec3 lo = tile_box(tile, h).lo;
  if (ruled_out(lo, kTileSize, deep)) return 0;
  Octants found = 0;
  for (int i = 0; i < 8; ++i) {
    const Vec3 octant = part_of(lo, kTileSize, i);
    if (ruled_out(octant, kTileSize / 2, deep)) continue;
    bool room = deep;
    for (int j = 0; j < 8 && !room; ++j) room = !ruled_out(part_of(octant, kTileSize / 2, j), kTileSize / 4, deep);
    if (room) found |= static_cast<Octants>(1 << i);
  }
  return found;
}

}  // namespace brim
