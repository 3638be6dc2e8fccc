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
  const std::int32_t first[3] = {limit.lo.x, limit.lo.y, limit.lo.z}, last[3] = {limit.hi.x, limit.hi.y, limit.hi.z};
  std::int32_t lo[3], hi[3];
  const double inverse = 1.0 / h;
  for (int a = 0; a < 3; ++a) {
    if (!(box.lo[a] <= box.hi[a])) return false;
    // Clip in floating point first: a far or broken position must not overflow an integer. Rounding by conversion to
    // integers, of numbers that are made positive first.
    const double base = static_cast<double>(kTileSize) * first[a] - kHalo;
    const double end = static_cast<double>(kTileSize) * last[a] + kTileSize + kHalo - base;
    const double from = box.lo[a] * inverse - kHalo - 1e-9 - base, to = box.hi[a] * inverse + kHalo + 1e-9 - base;
    if (!(from <= end) || !(to >= 0.0)) return false;
    // In nodes from the first one of the limit's first block.
    const auto node_lo = static_cast<std::int64_t>(from > 0.0 ? from : 0.0);
    const std::int64_t up = node_lo + (static_cast<double>(node_lo) < from);
    const auto node_hi = static_cast<std::int64_t>(to < end ? to : end);
    lo[a] = first[a] + static_cast<std::int32_t>((up - kHalo + kTileSize) / kTileSize - 1);
    hi[a] = first[a] + static_cast<std::int32_t>((node_hi - kHalo + kTileSize) / kTileSize - 1);
    lo[a] = std::max(lo[a], first[a]), hi[a] = std::min(hi[a], last[a]);
    if (lo[a] > hi[a]) return false;
  }
  out = {{lo[0], lo[1], lo[2]}, {hi[0], hi[1], hi[2]}};
  return true;
}

NodeRange nodes_in_box(const Aabb& box, const Vec3& origin, double h, Octants wanted) {
  constexpr int kUp = 16;  // makes positive what is rounded by conversion to integers
  NodeRange r = wanted_nodes(wanted);
  for (int a = 0; a < 3; ++a) {
    const auto clip = [](double v) { return v > -1.0 ? (v < kBlockSize ? v : double{kBlockSize}) : -1.0; };
    const double lo = clip((box.lo[a] - origin[a]) / h - 1e-9), hi = clip((box.hi[a] - origin[a]) / h + 1e-9);
    r.lo[a] = std::max(r.lo[a], kUp - static_cast<int>(kUp - lo));
    r.hi[a] = std::min(r.hi[a], static_cast<int>(hi + kUp) - kUp);
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
