#include "brim/raster/image_shape.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "brim/mesh/distance.h"
#include "brim/mesh/distance_spread.h"
#include "brim/mesh/isosurface.h"
#include "brim/raster/ball_field.h"
#include "brim/raster/grid_shape.h"

namespace brim {

namespace {

/// [cells] diameter of the balls whose filling tells the surface; wider ones round off more, narrower ones show the
/// cells.
constexpr double kBalls = 4.0;
/// Least share of cells of matter too thin to fill half a ball.
constexpr std::uint8_t kThinShare = 64;
/// [cells] around the matter: half a ramp, and what stencils of coarse voxels read.
constexpr int kAround = 6;
/// [cells] up to which distances are exact.
constexpr double kExact = 3.0;

/// The distance to half filling at the cells' centres, [m]: good near the surface.
std::vector<float> near_distances(const OccupancyGrid& grid) {
  const BallField field(grid, kBalls * grid.spacing);
  std::vector<float> d(grid.share.size());
  std::size_t c = 0;
  for (int k = 0; k < grid.cells.z(); ++k)
    for (int j = 0; j < grid.cells.y(); ++j)
      for (int i = 0; i < grid.cells.x(); ++i) d[c++] = static_cast<float>(field.distance(grid.center(i, j, k)));
  return d;
}

/// Puts cells inside that are fuller than those on both sides of them along some axis, where none around is: by half
/// the thickness of the matter there, the sum of the three shares.
void keep_thin_matter(const OccupancyGrid& grid, std::vector<float>& d) {
  const std::vector<float> found = d;
  const std::array<std::size_t, 3> step = {1, grid.index(0, 1, 0), grid.index(0, 0, 1)};
  // Two cells on, a thin layer has ended; a bulge of wider matter, or its faint border, has not.
  const auto ridge = [&](std::size_t c, std::size_t s) {
    const int here = grid.share[c];
    return here >= grid.share[c - s] && here > grid.share[c + s] &&
           here > 2 * std::max(grid.share[c - 2 * s], grid.share[c + 2 * s]);
  };
  for (int k = 2; k + 2 < grid.cells.z(); ++k)
    for (int j = 2; j + 2 < grid.cells.y(); ++j)
      for (int i = 2; i + 2 < grid.cells.x(); ++i) {
        const std::size_t c = grid.index(i, j, k);
        if (grid.share[c] < kThinShare || found[c] < 0.0f) continue;
        int thinnest = std::numeric_limits<int>::max();
        for (const std::size_t s : step)
          if (ridge(c, s)) thinnest = std::min(thinnest, grid.share[c - s] + grid.share[c] + grid.share[c + s]);
        if (thinnest == std::numeric_limits<int>::max()) continue;
        bool alone = true;
        for (int n = 0; n < 27 && alone; ++n)
          alone = !(found[grid.index(i + n % 3 - 1, j + n / 3 % 3 - 1, k + n / 9 - 1)] < 0.0f);
        if (alone) d[c] = -0.5f / 255.0f * static_cast<float>(grid.spacing * thinnest);
      }
}

}  // namespace

DistanceGrid distance_of_matter(const OccupancyGrid& matter) {
  const OccupancyGrid grid = widened_cells(matter, kAround);
  std::vector<float> d = near_distances(grid);
  keep_thin_matter(grid, d);
  const SurfaceTree skin(isosurface({grid.origin, grid.spacing, grid.cells, d}));
  const std::vector<float> to_skin =
      spread_distance({grid.origin, grid.spacing, grid.cells}, skin, kExact * grid.spacing,
                      [](const Vec3&, const ClosestPoint& c) { return static_cast<float>(c.distance); });
  for (std::size_t n = 0; n < d.size(); ++n) d[n] = d[n] < 0.0f ? -to_skin[n] : to_skin[n];
  return {grid.origin, grid.spacing, grid.cells, std::move(d)};
}

std::shared_ptr<const Shape> make_image_shape(const OccupancyGrid& matter, double thickness) {
  return make_grid_shape(std::make_shared<const DistanceGrid>(distance_of_matter(matter)), thickness);
}

}  // namespace brim
