#pragma once

#include <array>
#include <deque>
#include <span>
#include <vector>

#include "brim/body/grid_fluid/padded_box.h"

namespace brim {

/// One multigrid V-cycle for a GridMatrix, as a preconditioner: symmetric, positive, the same operation every time.
/// A coarse cell consists of 2x2x2 cells, and a coarse coupling is half the sum of the fine ones between two of them
/// (piecewise constant Galerkin coarsening would be twice too stiff: Braess 1995), so couplings may differ by orders of
/// magnitude and the wet region may have any shape.
///
/// Every level is scaled to a unit diagonal, A' = s A s with s = d^-1/2, in single precision. Smoother: Chebyshev
/// polynomials of A' over the upper part of its spectrum, which ends at 2 since d >= Σ a (Adams and others 2003); they
/// read one array and write another, eight cells at a time. Rows without unknowns are skipped. Memory is kept. Same
/// bits for any number of threads.  Tests: tests/body/grid_poisson_test.cpp
class GridMultigrid {
 public:
  /// Sets the matrix and builds the coarse levels.
  void set(const GridMatrix& matrix);
  const PaddedBox& box() const { return levels_.front().box; }
  /// Starts of the rows of the finest level with unknowns, in padded arrays.
  std::span<const std::size_t> rows() const { return levels_.front().rows; }
  /// s of the finest level, padded; 0 without unknown.
  std::span<const float> scale() const { return levels_.front().scale; }

  /// The right-hand side s b of the next cycle, padded, to be filled in; zero without unknown.
  std::span<float> scaled_rhs() { return levels_.front().b; }
  /// Runs a cycle. @return s⁻¹ x, x: its result, padded
  std::span<const float> cycle() {
    cycle(0);
    return found();
  }
  std::span<const float> found() const { return levels_.front().x; }

 private:
  struct Level {
    PaddedBox box;
    std::vector<std::size_t> rows;
    std::vector<float> scale, root;              ///< s and its inverse; 0 without unknown
    std::array<std::vector<float>, 3> coupling;  ///< s a s
    std::vector<float> b, x, other,
        step;  ///< right-hand side, solution and its second buffer, last step of the smoother
  };
  static void take(const GridMatrix& matrix, Level& level);
  static void coarsen(const GridMatrix& fine, GridMatrix& coarse);
  static void smooth(Level& level, int degree, double part, bool from_zero);
  static void residual(Level& level);
  static void restrict_to(Level& coarse, const Level& fine);
  static void prolong_to(Level& fine, const Level& coarse);
  void cycle(std::size_t l);

  std::deque<Level> levels_;
  std::size_t count_ = 0;
  std::array<GridMatrix, 2> coarse_;
};

}  // namespace brim
