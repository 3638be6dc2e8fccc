#include "brim/raster/tile_cover.h"

#include <atomic>

#include "brim/raster/tile_bins.h"

namespace brim {

namespace {
constexpr double kMaxMarks = 16e6;
}

void TileCover::begin(const Aabb& region, double h) {
  h_ = h;
  nx_ = ny_ = nz_ = 0;
  mark_.clear();
  const Vec3 lo = region.lo / (h * kTileSize), hi = region.hi / (h * kTileSize);
  if (!(lo.array() <= hi.array()).all() || !(lo.cwiseAbs().maxCoeff() < 1e9) || !(hi.cwiseAbs().maxCoeff() < 1e9))
    return;
  range_ = tiles_meeting(region.inflated(h * kHalo), h);
  // A region with more tiles than memory is covered in coarser marks: more tiles than needed, never too few.
  const Vec3 n(double(range_.hi.x) - range_.lo.x + 1, double(range_.hi.y) - range_.lo.y + 1,
               double(range_.hi.z) - range_.lo.z + 1);
  coarsening_ = 1;
  while ((n / double(coarsening_)).array().ceil().prod() > kMaxMarks) ++coarsening_;
  nx_ = static_cast<std::size_t>(std::ceil(n.x() / double(coarsening_)));
  ny_ = static_cast<std::size_t>(std::ceil(n.y() / double(coarsening_)));
  nz_ = static_cast<std::size_t>(std::ceil(n.z() / double(coarsening_)));
  mark_.assign(nx_ * ny_ * nz_, 0);
}

void TileCover::mark(const Aabb& box) {
  TileRange r;
  if (mark_.empty() || !tiles_of_box(box, h_, range_, r)) return;
  const auto place = [this](std::int32_t t, std::int32_t base) {
    return static_cast<std::size_t>(t - base) / coarsening_;
  };
  for (std::size_t z = place(r.lo.z, range_.lo.z); z <= place(r.hi.z, range_.lo.z); ++z)
    for (std::size_t y = place(r.lo.y, range_.lo.y); y <= place(r.hi.y, range_.lo.y); ++y)
      for (std::size_t x = place(r.lo.x, range_.lo.x); x <= place(r.hi.x, range_.lo.x); ++x) {
        // Threads may mark the same tile; all write the same value.
        std::atomic_ref<unsigned char> m(mark_[x + nx_ * (y + ny_ * z)]);
        if (m.load(std::memory_order_relaxed) == 0) m.store(1, std::memory_order_relaxed);
      }
}

void TileCover::append_to(std::vector<TileKey>& out) const {
  const auto c = static_cast<std::int32_t>(coarsening_);
  for (std::size_t z = 0, i = 0; z < nz_; ++z)
    for (std::size_t y = 0; y < ny_; ++y)
      for (std::size_t x = 0; x < nx_; ++x, ++i) {
        if (mark_[i] == 0) continue;
        const TileKey first{range_.lo.x + c * static_cast<std::int32_t>(x),
                            range_.lo.y + c * static_cast<std::int32_t>(y),
                            range_.lo.z + c * static_cast<std::int32_t>(z)};
        for (std::int32_t dz = 0; dz < c && first.z + dz <= range_.hi.z; ++dz)
          for (std::int32_t dy = 0; dy < c && first.y + dy <= range_.hi.y; ++dy)
            for (std::int32_t dx = 0; dx < c && first.x + dx <= range_.hi.x; ++dx)
              out.push_back({first.x + dx, first.y + dy, first.z + dz});
      }
}

}  // namespace brim
