#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "brim/map/map.h"
#include "brim/map/map_rows.h"
#include "brim/map/row_transpose.h"

namespace brim {

/// Map of bodies made of particles with three coordinates each: the velocity of a point is a weighted sum,
///   u_p = Σ_i w_pi v_i,   J_pi = w_pi I
/// (finite elements: shape functions; paper, section 5.1). When Σ w = 1 and Σ w x = r, linear and angular momentum of
/// contact are exact. Constant in q, so it has no geometric stiffness.
/// Products are parallel and give the same bits for any number of threads.  Tests: tests/map/point_weights_test.cpp
class PointWeightsMap final : public Map, public SparseMap {
 public:
  /// Weights of one point, to be filled in.
  struct Row {
    std::span<std::int32_t> particle;
    std::span<double> weight;
  };

  /// Allocates points with the same number of entries each; fill every row(), then call finish().
  /// @param particles  number of particles of the body, nv / 3
  void reset(std::size_t particles, std::size_t points, int entries_per_point);
  Row row(std::size_t point);
  /// Sets rows of any lengths. @param row_start  shape (points + 1); particle, weight: shape (row_start.back())
  void assign(std::size_t particles, std::span<const std::int32_t> row_start, std::span<const std::int32_t> particle,
              std::span<const double> weight);
  /// Rows are final from here on. Zero weights are allowed.
  void finish();

  std::size_t points() const override { return row_start_.empty() ? 0 : row_start_.size() - 1; }
  void apply(std::span<const double> v, std::span<Vec3> u) const override;
  void apply_transpose(std::span<const Vec3> f, std::span<double> Q) const override;
  bool append_rows(MapRows& out) const override;
  bool select(std::span<const std::uint32_t> rows, std::unique_ptr<Map>& out) const override;
  void add_block_diagonal(std::span<const Mat3> K, std::size_t first, BlockDiagonal& D) const override;

 private:
  /// Entry of a row, stored by particle.
  struct Share {
    double weight;
    std::int32_t row;
  };
  const RowShares<Share>& by_particle() const;

  std::size_t particles_ = 0;
  std::vector<std::int32_t> row_start_, particle_;
  std::vector<double> weight_;
  mutable RowShares<Share> by_particle_;
};

}  // namespace brim
