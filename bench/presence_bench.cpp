// Presence of a fluid that rasterizes itself: tiles found by a scan of their cells, and by a hierarchy of least values
// built bottom-up (paper, section 6),
// held to the same answers. A pool of n³ cells, half full, in a box; regions: all of it, and a ball's at its
// surface; the voxels of contact are the cells.

#include <benchmark/benchmark.h>

#include <cmath>

#include "brim/body/grid_fluid/mac_grid.h"
#include "brim/core/parallel.h"
#include "brim/grid/tile.h"
#include "least_pyramid.h"

namespace brim {
namespace {

struct Pool {
  MacGrid grid;
  std::vector<double> phi;
  explicit Pool(int n) {
    grid.dx = 1.0 / n;
    grid.n = Vec3i::Constant(n);
    for (int k = 0; k < n; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
          const Vec3 x = grid.cell_center(i, j, k);
          phi.push_back(x.z() - 0.5 - 0.05 * std::sin(9 * x.x()) * std::cos(7 * x.y()));
        }
  }
};

Aabb region_of(int which) {
  return which == 0 ? Aabb{Vec3::Zero(), Vec3::Ones()} : Aabb{Vec3(0.4, 0.4, 0.4), Vec3(0.6, 0.6, 0.6)};
}

/// Calls found(lo, hi) with the cells that each tile of a region may be interpolated from; counts the tiles present.
template <class Found>
std::int64_t count_tiles(const MacGrid& g, const Aabb& region, double h, const Found& found) {
  std::int64_t present = 0;
  const TileRange range = tiles_meeting(region.inflated(h), h);
  for (int z = range.lo.z; z <= range.hi.z; ++z)
    for (int y = range.lo.y; y <= range.hi.y; ++y)
      for (int x = range.lo.x; x <= range.hi.x; ++x) {
        const Aabb block = tile_box({x, y, z}, h).inflated(h);
        Vec3i lo, hi;
        for (int a = 0; a < 3; ++a) {
          const auto place = [&](double p) {
            return std::clamp(static_cast<int>(std::floor((p - g.origin[a]) / g.dx - 0.5)), 0, g.n[a] - 1);
          };
          lo[a] = place(block.lo[a]), hi[a] = std::min(place(block.hi[a]) + 1, g.n[a] - 1);
        }
        present += found(lo, hi);
      }
  return present;
}

bool scanned(const Pool& pool, const Vec3i& lo, const Vec3i& hi, double most) {
  for (int k = lo.z(); k <= hi.z(); ++k)
    for (int j = lo.y(); j <= hi.y(); ++j)
      for (int i = lo.x(); i <= hi.x(); ++i)
        if (pool.phi[pool.grid.cell(i, j, k)] < most) return true;
  return false;
}

void scan(benchmark::State& state) {
  const ThreadLimit one(1);
  const Pool pool(static_cast<int>(state.range(0)));
  const double h = pool.grid.dx, most = 1.5 * h;
  std::int64_t tiles = 0;
  for (auto _ : state)
    tiles = count_tiles(pool.grid, region_of(static_cast<int>(state.range(1))), h,
                        [&](const Vec3i& lo, const Vec3i& hi) { return scanned(pool, lo, hi, most); });
  state.counters["tiles"] = static_cast<double>(tiles);
}

/// @param built  the hierarchy is there: a second region of the same state
void bottom_up(benchmark::State& state, bool built) {
  const ThreadLimit one(1);
  const Pool pool(static_cast<int>(state.range(0)));
  const double h = pool.grid.dx, most = 1.5 * h;
  LeastPyramid pyramid;
  pyramid.build(pool.grid.n, pool.phi);
  bool same = true;
  count_tiles(pool.grid, region_of(0), h, [&](const Vec3i& lo, const Vec3i& hi) {
    same = same && pyramid.any_below(lo, hi, most) == scanned(pool, lo, hi, most);
    return true;
  });
  if (!same) return state.SkipWithError("the hierarchy finds other tiles than the scan");
  std::int64_t tiles = 0;
  for (auto _ : state) {
    if (!built) pyramid.build(pool.grid.n, pool.phi);
    tiles = count_tiles(pool.grid, region_of(static_cast<int>(state.range(1))), h,
                        [&](const Vec3i& lo, const Vec3i& hi) { return pyramid.any_below(lo, hi, most); });
  }
  state.counters["tiles"] = static_cast<double>(tiles);
}

BENCHMARK(scan)->ArgsProduct({{32, 64, 128}, {0, 1}})->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(bottom_up, building, false)->ArgsProduct({{32, 64, 128}, {0, 1}})->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(bottom_up, built, true)->ArgsProduct({{32, 64, 128}, {0, 1}})->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace brim
