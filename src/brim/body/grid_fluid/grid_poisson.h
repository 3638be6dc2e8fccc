#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "brim/body/grid_fluid/grid_multigrid.h"

namespace brim {

/// Solves symmetric positive (semi-)definite systems with the seven-point pattern of a box of cells (GridMatrix) by
/// conjugate gradients in double precision, preconditioned with one V-cycle in single precision (GridMultigrid). Cells
/// with d = 0 have no unknown. Memory is kept. Same bits for any number of threads.
/// Tests: tests/body/grid_poisson_test.cpp
class GridPoisson {
 public:
  /// Allocates and sets the matrix to zero; fill finest(), then call finish().
  void reset(const Vec3i& n) { matrix_.reset(n); }
  GridMatrix& finest() { return matrix_; }
  /// Processes the matrix and builds the coarse levels.
  void finish();

  /// @param x          initial guess on entry, solution on return
  /// @param tolerance  for the largest residual, in the units of b
  /// @return number of iterations
  int solve(std::span<const double> b, double tolerance, int max_iterations, std::span<double> x);

  // For solvers that add terms to A; values of cells without unknown are neither read nor written.
  /// y = A x.
  void multiply(std::span<const double> x, std::span<double> y);
  /// z = one cycle applied to r: symmetric, positive.
  void cycle(std::span<const double> r, std::span<double> z);

 private:
  double apply(std::span<const double> x, std::span<double> y);
  double advance(double step);
  double precondition(double most);
  void turn(double ratio, double most);

  /// A cell with an unknown, and its place in padded arrays.
  struct Known {
    std::uint32_t at, cell;
  };

  GridMatrix matrix_;
  GridMultigrid multigrid_;
  std::vector<Known> known_;
  std::vector<double> diagonal_;  ///< padded, as all below
  std::array<std::vector<double>, 3> coupling_;
  std::vector<double> x_, r_, p_, y_;
  std::vector<double> part_;  ///< sums over blocks of rows
};

}  // namespace brim
