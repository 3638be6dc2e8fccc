#include "brim/raster/averaged_solid.h"

#include <algorithm>
#include <cmath>
#include <mutex>

namespace brim {

namespace {

/// A ball's diameter over the cells that it is made of: at least this many.
constexpr double kCells = 6.0;

}  // namespace

int OccupancyPyramid::level_of(double w) const {
  const double cells = w / (kCells * levels_.front().spacing);
  return cells >= 2.0 ? static_cast<int>(std::floor(std::log2(cells) + 1e-9)) : 0;
}

const BallField& OccupancyPyramid::field(double w) const {
  {
    const std::shared_lock lock(mutex_);
    if (const auto it = fields_.find(w); it != fields_.end()) return *it->second;
  }
  // Made by one thread: a parallel loop in here could wait for a thread that waits for this lock.
  const std::unique_lock lock(mutex_);
  auto& field = fields_[w];
  if (field) return *field;
  const auto level = static_cast<std::size_t>(level_of(w));
  while (levels_.size() <= level) levels_.push_back(halved_cells(levels_.back()));
  // Half a ramp and a cell around the matter, so that the ball is empty at the border.
  const OccupancyGrid& grid = levels_[level];
  const int around = level == 0 ? 0 : static_cast<int>(std::ceil(0.5 * w / grid.spacing)) + 1;
  field = std::make_unique<BallField>(around == 0 ? grid : widened_cells(grid, around), w);
  return *field;
}

OccupancyGrid occupancy_of(const DistanceGrid& grid) {
  OccupancyGrid out;
  out.origin = grid.origin();
  out.spacing = grid.spacing();
  out.cells = grid.nodes();
  out.share.resize(grid.values().size());
  std::transform(grid.values().begin(), grid.values().end(), out.share.begin(), [&](float d) {
    return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(0.5 - d / grid.spacing(), 0.0, 1.0)));
  });
  return out;
}

double AveragedSolid::rough_distance(const Vec3& p) const {
  const double d = grid_.value(p, Interpolation::Trilinear), half = 0.5 * field_.width();
  return std::abs(d) > half + grid_.spacing() ? d : field_.distance(p);
}

}  // namespace brim
