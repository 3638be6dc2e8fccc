#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "brim/map/map.h"
#include "brim/map/map_rows.h"

namespace brim {

/// Map of balls that rotate about their centres x_i, six velocities each, (v_i, ω_i):
///   u_p = v_i + ω_i × (r_p − x_i),   J_pᵀ f = (f, (r_p − x_i) × f)
/// Linear and angular momentum of contact are exact.  Tests: tests/map/balls_map_test.cpp
class BallsMap final : public Map, public SparseMap {
 public:
  /// @param x       [m] centres  @param points  [m]
  /// @param ball    index of each point's ball
  void reset(std::span<const Vec3> x, std::span<const Vec3> points, std::span<const std::int32_t> ball);

  std::size_t points() const override { return arm_.size(); }
  void apply(std::span<const double> v, std::span<Vec3> u) const override;
  void apply_transpose(std::span<const Vec3> f, std::span<double> Q) const override;
  bool append_rows(MapRows& out) const override;
  bool select(std::span<const std::uint32_t> rows, std::unique_ptr<Map>& out) const override;
  void add_block_diagonal(std::span<const Mat3> K, std::size_t first, BlockDiagonal& D) const override;

 private:
  std::vector<std::int32_t> ball_;
  std::vector<Vec3> arm_;  ///< r − x, [m]
};

}  // namespace brim
