#include "brim/raster/tile_bins.h"

#include <algorithm>
#include <cmath>

namespace brim {

void TileIndex::build(std::span<const TileKey> tiles) {
  constexpr std::int32_t kMax = std::numeric_limits<std::int32_t>::max();
  range_ = {{kMax, kMax, kMax}, {-kMax, -kMax, -kMax}};
  for (const TileKey& t : tiles) {
    range_.lo = {std::min(range_.lo.x, t.x), std::min(range_.lo.y, t.y), std::min(range_.lo.z, t.z)};
    range_.hi = {std::max(range_.hi.x, t.x), std::max(range_.hi.y, t.y), std::max(range_.hi.z, t.z)};
  }
  tiles_.assign(tiles.begin(), tiles.end());
  slot_.clear();
  sorted_.clear();
  dense_ = true;
  if (tiles.empty()) return;
  nx_ = std::int64_t{range_.hi.x} - range_.lo.x + 1;
  ny_ = std::int64_t{range_.hi.y} - range_.lo.y + 1;
  const double nz = static_cast<double>(range_.hi.z) - range_.lo.z + 1.0;
  const double volume = static_cast<double>(nx_) * static_cast<double>(ny_) * nz;
  dense_ = volume <= 65536.0 + 16.0 * static_cast<double>(tiles.size());
  if (dense_) {
    slot_.assign(static_cast<std::size_t>(volume), 0);
    for (std::size_t i = 0; i < tiles.size(); ++i) {
      const TileKey& t = tiles[i];
      slot_[(t.x - range_.lo.x) + nx_ * ((t.y - range_.lo.y) + ny_ * (t.z - range_.lo.z))] =
          static_cast<std::int32_t>(i) + 1;
    }
  } else {
    for (std::size_t i = 0; i < tiles.size(); ++i) sorted_.emplace_back(tiles[i], static_cast<std::int32_t>(i));
    std::sort(sorted_.begin(), sorted_.end());
  }
}

std::int32_t TileIndex::find(std::int32_t x, std::int32_t y, std::int32_t z) const {
  if (x < range_.lo.x || x > range_.hi.x || y < range_.lo.y || y > range_.hi.y || z < range_.lo.z || z > range_.hi.z)
    return -1;
  if (dense_) return slot_[(x - range_.lo.x) + nx_ * ((y - range_.lo.y) + ny_ * (z - range_.lo.z))] - 1;
  const TileKey key{x, y, z};
  const auto it = std::lower_bound(sorted_.begin(), sorted_.end(), key,
                                   [](const auto& a, const TileKey& b) { return a.first < b; });
  return it != sorted_.end() && it->first == key ? it->second : -1;
}

bool tiles_of_box(const Aabb& box, double h, const TileRange& limit, TileRange& out) {
  // Clip in floating point first: a far or broken position must not overflow an integer.
  const Vec3 lo = h * kTileSize * Vec3(limit.lo.x, limit.lo.y, limit.lo.z) - Vec3::Constant(h);
  const Vec3 hi = h * kTileSize * (Vec3(limit.hi.x, limit.hi.y, limit.hi.z) + Vec3::Ones());
  const Aabb reach = box.inflated(h * kHalo);
  const Vec3 a = reach.lo.cwiseMax(lo), b = reach.hi.cwiseMin(hi);
  if (!(a.array() <= b.array()).all()) return false;
  if (!(box.lo.array() <= box.hi.array()).all()) return false;
  out = tiles_meeting({a, b}, h);
  out.lo = {std::max(out.lo.x, limit.lo.x), std::max(out.lo.y, limit.lo.y), std::max(out.lo.z, limit.lo.z)};
  out.hi = {std::min(out.hi.x, limit.hi.x), std::min(out.hi.y, limit.hi.y), std::min(out.hi.z, limit.hi.z)};
  return out.lo.x <= out.hi.x && out.lo.y <= out.hi.y && out.lo.z <= out.hi.z;
}

NodeRange nodes_in_box(const Aabb& box, const Vec3& origin, double h, Octants wanted) {
  // Octants of the lower half along each axis; those of the upper are the others.
  constexpr Octants kLower[3] = {0x55, 0x33, 0x0f};
  constexpr int kHalf = kTileSize / 2;
  NodeRange r;
  for (int a = 0; a < 3; ++a) {
    r.lo[a] = static_cast<int>(std::ceil(std::clamp((box.lo[a] - origin[a]) / h - 1e-9, -1.0, double{kBlockSize})));
    r.hi[a] = static_cast<int>(std::floor(std::clamp((box.hi[a] - origin[a]) / h + 1e-9, -1.0, double{kBlockSize})));
    r.lo[a] = std::max(r.lo[a], wanted & kLower[a] ? 0 : kHalf);
    r.hi[a] = std::min(r.hi[a], wanted & ~kLower[a] ? kBlockSize - 1 : kHalf + 2 * kHalo - 1);
  }
  return r;
}

void TileBins::sort(std::size_t blocks, std::size_t tile_count) {
  first_.assign(tile_count + 1, 0);
  for (std::size_t b = 0; b < blocks; ++b)
    for (const Pair& p : pairs_[b]) ++first_[p.tile + 1];
  for (std::size_t t = 0; t < tile_count; ++t) first_[t + 1] += first_[t];
  next_.assign(first_.begin(), first_.end() - 1);
  items_.resize(first_[tile_count]);
  for (std::size_t b = 0; b < blocks; ++b)
    for (const Pair& p : pairs_[b]) items_[next_[p.tile]++] = p.primitive;
}

}  // namespace brim
