#pragma once

#include <deque>
#include <span>
#include <vector>

#include "brim/body/grid_fluid/mac_grid.h"

namespace brim {

/// Solves symmetric positive (semi-)definite systems with the seven-point pattern of a box of cells,
///   d_c x_c − Σ_neighbours a_cn x_n = b_c,     a >= 0, d_c >= Σ a_cn
/// by conjugate gradients preconditioned with one multigrid V-cycle. Coarse cells join 2x2x2 cells, and a coarse
/// coupling is the sum of the fine ones between two of them, halved (piecewise constant Galerkin coarsening would be
/// twice too stiff: Braess 1995), so that couplings may differ by orders of magnitude and the wet region may have any
/// shape. Smoother: red-black Gauss-Seidel, forth on the way down and back on the way up, so that the cycle is
/// symmetric. Cells with d = 0 take no part. Memory is kept. Same bits for any number of threads. Tests:
/// tests/body/grid_poisson_test.cpp
class GridPoisson {
 public:
  /// Matrix of one level, to be filled by the caller for the finest.
  struct Level {
    Vec3i n;
    std::vector<double> diagonal;                 ///< d, shape (cells); 0: no unknown
    std::array<std::vector<double>, 3> coupling;  ///< a with the next cell along x, y, z, shape (cells)
    std::vector<double> x, b, r, inverse;
  };

  /// Makes room and sets the matrix to zero; fill finest(), then call finish().
  void reset(const Vec3i& n);
  Level& finest() { return levels_.front(); }
  const Level& finest() const { return levels_.front(); }
  /// Makes the coarse levels.
  void finish();

  /// @param x          first guess on entry, solution on return
  /// @param tolerance  of the largest residual, in the units of b
  /// @return number of iterations
  int solve(std::span<const double> b, double tolerance, int max_iterations, std::span<double> x);
  /// y = A x on the finest level.
  void apply(std::span<const double> x, std::span<double> y) const;

 private:
  void coarsen(const Level& fine, Level& coarse);
  void smooth(Level& level, bool forth);
  void residual(Level& level) const;
  void cycle(std::size_t l);

  std::deque<Level> levels_;  ///< a deque, so that finest() stays where it is
  std::size_t count_ = 0;
  std::vector<double> r_, z_, p_, y_;
};

}  // namespace brim
