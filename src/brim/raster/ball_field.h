#pragma once

#include <cstdint>
#include <vector>

#include "brim/mesh/occupancy.h"

namespace brim {

/// Density of matter in cells at one ramp width: the volume fraction of matter in a ball about each point.
///   rho(r) = |matter ∩ ball(r, R)| / |ball|,  R = w/2
/// The volume of a ball cut by a plane is a cubic smoothstep of the plane's distance, so at a flat surface rho =
/// ramp(d, w) exactly: solids averaged for coarse voxels (AveragedSolid) meet others with the density that distances
/// have, and ramp_inverse(rho, w) is the distance near the surface (distance_of_matter). Stored as the distance d =
/// ramp_inverse(rho, w) at cell centres, since its trilinear interpolation is exact at flat surfaces; only bricks of
/// 8x8x8 cells in which rho varies take memory. Averaging within cells widens the ramp like a box filter of their size;
/// the ball is made smaller by the same variance, R² = w²/4 − 5 s²/12. Tests: tests/raster/image_shape_test.cpp
class BallField {
 public:
  /// @param w  [m] ramp width; at least twice the spacing of the grid is used
  /// One thread; about 0.1 µs a cell of the bricks along the surface.
  BallField(const OccupancyGrid& grid, double w);

  /// Distance to the surface from the density, [m]: within ±w/2, negative inside.
  double distance(const Vec3& p) const;
  double width() const { return w_; }
  /// 1 if all is empty, -1 if all is full within a box, 0 otherwise or when the test is too expensive.
  int uniform(const Aabb& box) const;
  std::size_t bytes() const { return (value_.size() + brick_.size()) * 4; }

  static constexpr int kBrick = 8;

 private:
  static constexpr int kSide = kBrick + 1;  // bricks share their outer nodes
  static constexpr std::int32_t kEmpty = -1, kFull = -2;
  /// @return 1 or -1 when all is empty or full within reach of the brick; out is then unchanged
  int fill(const OccupancyGrid& grid, const Vec3i& brick, float* out) const;
  std::int32_t brick(const Vec3i& b) const {
    return brick_[static_cast<std::size_t>(b.x()) +
                  static_cast<std::size_t>(bricks_.x()) *
                      (static_cast<std::size_t>(b.y()) +
                       static_cast<std::size_t>(bricks_.y()) * static_cast<std::size_t>(b.z()))];
  }

  struct Row {  // of cells in the ball
    int j, k;
    double half;  // [cells] half its length
  };
  Vec3 origin_;
  double spacing_, w_;
  Vec3i cells_, bricks_;
  int reach_ = 0;  // [cells]
  std::vector<Row> rows_;
  double whole_ = 0.0;               // Σ 2 half
  std::vector<std::int32_t> brick_;  // kEmpty, kFull or index in value_
  std::vector<float> value_;         // [m]
};

}  // namespace brim
