#pragma once

#include <memory>

#include "brim/map/map.h"
#include "brim/map/row_transpose.h"
#include "brim/map/weight_rows.h"

namespace brim {

/// Points that follow particles by rows of weights, where the particles follow a body by any other map (paper, section
/// 5.4: the volume layer between a body and the grid):
///   u = W (J v),   Q = Jᵀ (Wᵀ f)
/// When particles follow nodes by sparse weights, compose() gives one sparse map, which is cheaper. The block diagonal
/// of Jᵀ Wᵀ K W J is replaced by an upper bound that needs only the body's map, Jᵀ diag(k_i) J with k_i = Σ_p |w_pi|
/// s_p K_p, s_p = Σ_i |w_pi|: good for preconditioning, not exact. Levers count with their magnitude. Tests:
/// tests/map/weight_rows_test.cpp
class ComposedMap final : public Map {
 public:
  /// @param rows   weights over the points of `inner`
  /// @param inner  map of the particles, one point per particle
  void assign(WeightRows rows, std::unique_ptr<Map> inner);

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
