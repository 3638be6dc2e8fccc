#pragma once

#include <cstdint>
#include <vector>

#include "brim/mesh/occupancy.h"

namespace brim {

/// The density of an image at one ramp width: the share of matter in a ball about each point.
///   rho(r) = |matter ∩ ball(r, R)| / |ball|,  R = w/2
/// The integral of a ball's section over its height is the cubic smoothstep, so at a flat surface rho = ramp(d, w)
/// exactly: images meet other bodies with the same density that distance gives elsewhere, without any surface. Kept as
/// the distance d = ramp_inverse(rho, w) at the cells' centres, because trilinear interpolation is exact for that at
/// flat surfaces; only bricks of 8x8x8 cells that rho varies in take memory.
/// The cells' own average widens the ramp as a box of their size does; the ball is taken smaller by as much variance,
/// R² = w²/4 − 5 s²/12.
/// Tests: tests/raster/image_shape_test.cpp
class BallField {
 public:
  /// @param w  [m] ramp width, at least twice the spacing of the grid; a narrower one is taken as that wide
  /// One thread; about 0.1 µs a cell of the bricks along the surface.
  BallField(const OccupancyGrid& grid, double w);

  /// Distance to the surface as the density tells it, [m]: within ±w/2, negative inside.
  double distance(const Vec3& p) const;
  double width() const { return w_; }
  /// 1 where all is empty, -1 where all is full within a box, 0 otherwise or when it is not worth finding out.
  int uniform(const Aabb& box) const;
  std::size_t bytes() const { return (value_.size() + brick_.size()) * 4; }

  static constexpr int kBrick = 8;

 private:
  static constexpr int kSide = kBrick + 1;  // bricks share their outer nodes
  static constexpr std::int32_t kEmpty = -1, kFull = -2;
  /// @return 1 or -1 when nothing or everything is filled within reach of the brick; out is then left alone
  int fill(const OccupancyGrid& grid, const Vec3i& brick, float* out) const;
  std::int32_t brick(const Vec3i& b) const {
    return brick_[static_cast<std::size_t>(b.x()) +
                  static_cast<std::size_t>(bricks_.x()) *
                      (static_cast<std::size_t>(b.y()) +
                       static_cast<std::size_t>(bricks_.y()) * static_cast<std::size_t>(b.z()))];
  }

  struct Row {  // of cells in the ball
    int j, k;
    double half;  ///< [cells] half of its length
  };
  Vec3 origin_;
  double spacing_, w_;
  Vec3i cells_, bricks_;
  int reach_ = 0;  // [cells]
  std::vector<Row> rows_;
  double whole_ = 0.0;               // Σ 2 half
  std::vector<std::int32_t> brick_;  // kEmpty, kFull or place in value_
  std::vector<float> value_;         // [m]
};

}  // namespace brim
