#pragma once

#include <Eigen/Core>
#include <vector>

#include "brim/map/map.h"

namespace brim {

/// Map of bodies with few coordinates that all move every point: J_p is one dense matrix per point.
/// Such a body has a single block of nv unknowns. Same bits for any number of threads.
/// Tests: tests/body/own_body_test.cpp
class DenseMap final : public Map {
 public:
  using Jacobian = Eigen::Matrix<double, 3, Eigen::Dynamic>;

  /// Allocates n points, whose matrices are then set one by one. @param coordinates  nv
  void reset(std::size_t n, std::size_t coordinates);
  /// J of point p, shape (3, nv).
  Eigen::Map<Jacobian> row(std::size_t p) { return {value_.data() + 3 * nv_ * p, 3, static_cast<Eigen::Index>(nv_)}; }
  Eigen::Map<const Jacobian> row(std::size_t p) const {
    return {value_.data() + 3 * nv_ * p, 3, static_cast<Eigen::Index>(nv_)};
  }

  std::size_t points() const override { return points_; }
  void apply(std::span<const double> v, std::span<Vec3> u) const override;
  void apply_transpose(std::span<const Vec3> f, std::span<double> Q) const override;
  void add_block_diagonal(std::span<const Mat3> K, std::size_t first, BlockDiagonal& D) const override;

 private:
  std::size_t points_ = 0, nv_ = 0;
  std::vector<double> value_;  // shape (points, nv, 3)
};

}  // namespace brim
