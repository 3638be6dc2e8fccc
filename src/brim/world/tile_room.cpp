#include "brim/world/tile_room.h"

#include <algorithm>
#include <cmath>

namespace brim {

namespace {

/// Largest t with 3 t² − 2 t³ <= margin, from above: t² = margin/(3 − 2 t), and t <= 1/2 as long as margin <= 1/2.
double widest_gap(double margin) { return margin <= 0.5 ? std::sqrt(0.5 * std::max(0.0, margin)) : 1.0; }

}  // namespace

bool may_hold_contact(const BoundedPart& a, const BoundedPart& b, const ContactPair& pair, const TileKey& tile) {
  const double h = pair.h, gap = widest_gap(pair.margin) * pair.w;
  const auto any = [&](const auto& self, const Vec3& lo, int nodes) -> bool {
    const double half = 0.5 * (nodes - 1) * h;
    const Vec3 center = lo + Vec3::Constant(half);
    const double sum = a.body->distance_bound(a.part, center) + b.body->distance_bound(b.part, center);
    if (sum > gap + 2.0 * std::sqrt(3.0) * half + 1e-9 * h) return false;
    if (nodes == 2 || !(sum > gap)) return true;
    for (int i = 0; i < 8; ++i)
      if (self(self, lo + 0.5 * nodes * h * Vec3(i & 1, (i >> 1) & 1, i >> 2), nodes / 2)) return true;
    return false;
  };
  return any(any, tile_box(tile, h).lo, kTileSize);
}

}  // namespace brim
