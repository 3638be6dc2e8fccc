#pragma once

#include "brim/map/map.h"
#include "brim/map/map_rows.h"
#include "brim/map/row_transpose.h"
#include "brim/map/weight_rows.h"

namespace brim {

/// Map of bodies made of particles with three coordinates each, by weight rows with or without levers:
///   J_pi = w_pi I + n_p b_piᵀ,   J_piᵀ f = w_pi f + b_pi (n_p · f)
/// Constant during a solve; the change of the rows with q is neglected.
/// Products are parallel and give the same bits for any number of threads.  Tests: tests/map/weight_rows_test.cpp
class RowsMap final : public Map, public SparseMap {
 public:
  /// @param particles  number of particles of the body, nv / 3
  void assign(std::size_t particles, WeightRows rows);

  std::size_t points() const override { return rows_.rows(); }
  void apply(std::span<const double> v, std::span<Vec3> u) const override;
  void apply_transpose(std::span<const Vec3> f, std::span<double> Q) const override;
  bool append_rows(MapRows& out) const override;
  void add_block_diagonal(std::span<const Mat3> K, std::size_t first, BlockDiagonal& D) const override;
  const WeightRows& rows() const { return rows_; }

 private:
  WeightRows rows_;
  RowTranspose transpose_;
};

}  // namespace brim
