#include "brim/raster/tile_cover.h"

#include <algorithm>

#include "brim/raster/tile_bins.h"

namespace brim {

namespace {
constexpr double kMaxMarks = 16e6;
}

void TileCover::begin(const Aabb& region, double h, int halo) {
  h_ = h;
  nx_ = ny_ = nz_ = 0;
  mark_.clear();
  const Vec3 lo = region.lo / (h * kTileSize), hi = region.hi / (h * kTileSize);
  if (!(lo.array() <= hi.array()).all() || !(lo.cwiseAbs().maxCoeff() < 1e9) || !(hi.cwiseAbs().maxCoeff() < 1e9))
    return;
  range_ = tiles_meeting(region.inflated(h * halo), h);
  region_ = nodes_in(region, h, 1e-9);
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

template <class Box>
void TileCover::mark_tiles(const Box& box) {
  TileRange r;
  if (!tiles_of_box(box, h_, range_, r)) return;
  const auto place = [this](std::int32_t t, std::int32_t base) {
    return static_cast<std::size_t>(t - base) / coarsening_;
  };
  for (std::size_t z = place(r.lo.z, range_.lo.z); z <= place(r.hi.z, range_.lo.z); ++z)
    for (std::size_t y = place(r.lo.y, range_.lo.y); y <= place(r.hi.y, range_.lo.y); ++y)
      for (std::size_t x = place(r.lo.x, range_.lo.x); x <= place(r.hi.x, range_.lo.x); ++x)
        mark(x + nx_ * (y + ny_ * z), kAllOctants);
}

template void TileCover::mark_tiles(const Aabb&);
template void TileCover::mark_tiles(const NodeSpan&);

void TileCover::mark_octants(const NodeSpan& nodes) {
  if (coarsening_ > 1) return mark_tiles(nodes);
  static_assert(kTileSize == 8);
  std::int32_t lo[3], hi[3];  // octants
  for (int a = 0; a < 3; ++a) {
    lo[a] = std::max(nodes.lo[a], region_.lo[a]), hi[a] = std::min(nodes.hi[a], region_.hi[a]);
    if (lo[a] > hi[a]) return;
    lo[a] >>= 2, hi[a] >>= 2;
  }
  for (std::int32_t z = lo[2] >> 1; z <= hi[2] >> 1; ++z)
    for (std::int32_t y = lo[1] >> 1; y <= hi[1] >> 1; ++y)
      for (std::int32_t x = lo[0] >> 1; x <= hi[0] >> 1; ++x) {
        // Those of the tile's lower and upper octants along each axis that lie within the range.
        const auto halves = [](std::int32_t tile, std::int32_t from, std::int32_t to, Octants lower) {
          return static_cast<Octants>((2 * tile >= from ? lower : 0) | (2 * tile + 1 <= to ? ~lower : 0));
        };
        const auto place = [](std::int32_t t, std::int32_t base) { return static_cast<std::size_t>(t - base); };
        mark(place(x, range_.lo.x) + nx_ * (place(y, range_.lo.y) + ny_ * place(z, range_.lo.z)),
             halves(x, lo[0], hi[0], 0x55) & halves(y, lo[1], hi[1], 0x33) & halves(z, lo[2], hi[2], 0x0f));
      }
}

}  // namespace brim
