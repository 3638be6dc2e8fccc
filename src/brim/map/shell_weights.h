#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "brim/map/map.h"
#include "brim/map/row_transpose.h"

namespace brim {

/// Map of sheets: a point rides on a triangle x_0 x_1 x_2 with unit normal n, at a distance d from its plane,
///   r = Σ b_i x_i + d n(x),   b, d constant
///   ∂n = − Σ ∇b_i (n · ∂x_i),   ∇b_i: gradient of b_i in the plane of the triangle
///   J_i = b_i I − d ∇b_i nᵀ,     J_iᵀ f = b_i f − d n (∇b_i · f)
/// Σ J_i = I and Σ x_i × J_iᵀ f = r × f, so linear and angular momentum of contact are exact also for points off the
/// middle surface. J changes with q; the geometric term is left out (it is not definite and contact forces are small
/// against the stiffness of the sheet).
/// Products are parallel and give the same bits for any number of threads.  Tests: tests/map/shell_weights_test.cpp
class ShellWeightsMap final : public Map {
 public:
  /// @param particles  number of particles of the body, nv / 3
  void reset(std::size_t particles, std::size_t points);
  /// Lets point p at r ride on a triangle. Weights extrapolate linearly where r projects outside of the triangle, until
  /// Σ|b| passes kMaxWeight; there (slivers, far points) b becomes that of the closest point and d = 0.
  /// May run in parallel for different p. @param x  positions of the particles, [m], shape (particles)
  void set(std::size_t p, const Vec3& r, const std::array<std::int32_t, 3>& triangle, std::span<const Vec3> x);
  /// Prepares the products. O(particles + points).
  void finish();

  std::size_t points() const override { return normal_.size(); }
  void velocity(std::span<const double> v, std::span<Vec3> u) const override;
  void add_force(std::span<const Vec3> f, std::span<double> Q) const override;
  void add_block_diagonal(std::span<const Mat3> K, std::size_t first, BlockDiagonal& D) const override;

  /// Largest Σ|b| for which weights are extrapolated.
  static constexpr double kMaxWeight = 8.0;

 private:
  std::size_t particles_ = 0;
  std::vector<std::int32_t> row_start_, particle_;  // three entries a row
  std::vector<double> weight_;                      // b_i
  std::vector<Vec3> lever_;                         // −d ∇b_i, per entry
  std::vector<Vec3> normal_;                        // n, per point
  RowTranspose transpose_;
};

}  // namespace brim
