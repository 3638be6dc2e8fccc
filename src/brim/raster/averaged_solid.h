#pragma once

#include <map>
#include <memory>
#include <shared_mutex>
#include <vector>

#include "brim/mesh/distance_grid.h"
#include "brim/mesh/occupancy.h"
#include "brim/raster/ball_field.h"
#include "brim/raster/known_distance.h"

namespace brim {

/// Density fields of a solid at several ramp widths, each computed from the level of a pyramid of its matter with about
/// three cells per ball radius: level 0 is the given grid, each next one the means of 2x2x2 cells (a box filter). A
/// level of half the size costs an eighth of memory and time. Tests: tests/raster/averaged_solid_test.cpp
class OccupancyPyramid {
 public:
  explicit OccupancyPyramid(OccupancyGrid finest) { levels_.push_back(std::move(finest)); }
  const OccupancyGrid& finest() const { return levels_.front(); }
  /// The field of a ramp width, [m]; built by one thread on the first request.
  const BallField& field(double w) const;
  /// The level from which a width is computed.
  int level_of(double w) const;

 private:
  mutable std::shared_mutex mutex_;
  mutable std::vector<OccupancyGrid> levels_;
  mutable std::map<double, std::unique_ptr<BallField>> fields_;
};

/// The matter of a sampled distance: cells about its nodes, filled to 1/2 − d / spacing.
OccupancyGrid occupancy_of(const DistanceGrid& grid);

/// A solid of a sampled distance, averaged over balls. Beyond half a ramp from the surface the ball is full or empty,
/// and the distance is that of the grid.
class AveragedSolid final : public KnownDistance {
 public:
  /// @param field  of the width w [m]; both must outlive this
  AveragedSolid(const DistanceGrid& grid, const BallField& field) : grid_(grid), field_(field) {}
  /// Averaged and true distance differ by less than a ramp's width.
  double slack() const override { return field_.width() + grid_.spacing(); }
  double rough_distance(const Vec3& p) const override;
  bool by_rows() const override { return false; }

 private:
  const DistanceGrid& grid_;
  const BallField& field_;
};

}  // namespace brim
