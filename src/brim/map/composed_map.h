#pragma once

#include <memory>

#include "brim/map/map.h"
#include "brim/map/row_transpose.h"
#include "brim/map/weight_rows.h"

namespace brim {

/// Points that follow particles by rows of weights, where the particles follow a body by any map of its own (paper,
/// section 5.4: the volume layer between a body and the grid):
///   u = W (J v),   Q = Jᵀ (Wᵀ f)
/// For particles that follow nodes by sparse weights, compose() makes one sparse map, which is cheaper.
/// The block diagonal of Jᵀ Wᵀ K W J is replaced by that of Jᵀ diag(k_i) J with k_i = Σ_p |w_pi| s_p K_p, s_p = Σ_i
/// |w_pi|, which bounds it from above and needs the body's map alone: good for preconditioning, not exact. Levers count
/// by their size. Tests: tests/map/weight_rows_test.cpp
class ComposedMap final : public Map {
 public:
  /// @param rows   weights over the points of `inner`
  /// @param inner  map of the particles, one point each
  void assign(WeightRows rows, std::unique_ptr<Map> inner);
  /// Gives the inner map back, to be refilled.
  std::unique_ptr<Map> release_inner() { return std::move(inner_); }

  std::size_t points() const override { return rows_.rows(); }
  void apply(std::span<const double> v, std::span<Vec3> u) const override;
  void apply_transpose(std::span<const Vec3> f, std::span<double> Q) const override;
  void add_geometric(std::span<const Vec3> f, std::span<const double> dq, std::span<double> Q) const override;
  void add_block_diagonal(std::span<const Mat3> K, std::size_t first, BlockDiagonal& D) const override;

 private:
  void spread(std::span<const Vec3> f) const;

  WeightRows rows_;
  RowTranspose transpose_;
  std::unique_ptr<Map> inner_;
  mutable std::vector<Vec3> particle_;
};

}  // namespace brim
