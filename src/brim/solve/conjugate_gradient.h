#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace brim {

/// A linear system as seen by the solver, which knows nothing of bodies (paper, section 6).
struct LinearSystem {
  std::function<void(std::span<const double> x, std::span<double> y)> apply;         ///< y = A x
  std::function<void(std::span<const double> r, std::span<double> z)> precondition;  ///< z = P⁻¹ r
  std::function<void(std::span<double> x)> filter;  ///< zero in the prescribed directions
  /// Unknowns first[i] to first[i + 1] belong to island island[i]. Neither A nor P⁻¹ couples two islands, so each is a
  /// system of its own. Shapes (slices + 1) and (slices); both empty: a single island.
  std::span<const std::size_t> first{};
  std::span<const std::int32_t> island{};
  /// Ranges [begin, end) of unknowns, ascending, in which filter sets all to zero: no work is done on them.
  std::span<const std::array<std::size_t, 2>> idle{};
  /// Per island: xᵀ A x below which a solution is negligible and any guess is accepted. Empty: 0.
  std::span<const double> negligible{};
  /// Per island: factor on the tolerance. Empty: 1.
  std::span<const double> sharpness{};
};

struct SolveReport {
  int iterations = 0;  ///< of the slowest island
  /// |S(b − A x)| over |S b| in the preconditioner's norm and over the island's sharpness, the largest of the islands
  double residual = 0.0;
  bool converged = false;
  bool finite = true;
};

/// Solves S A S x = S b by preconditioned conjugate gradient, S the filter (Baraff and Witkin 1998, section 5.3; here
/// the prescribed directions of x are zero). Islands are iterated side by side, each with its own step lengths and end:
/// the accuracy of one does not depend on forces elsewhere. Vectors are kept between calls.
/// Tests: tests/solve/conjugate_gradient_test.cpp
class ConjugateGradient {
 public:
  /// @param x      initial guess on entry, solution on return; filtered
  /// @param scale  per island: reference value of |S b|², from an earlier solve of nearly the same system. Empty, or
  ///               for x = 0: computed here and returned
  /// Same bits for any number of threads.
  SolveReport solve(const LinearSystem& system, std::span<const double> b, double tolerance, int max_iterations,
                    std::span<double> x, std::vector<double>& scale);
  SolveReport solve(const LinearSystem& system, std::span<const double> b, double tolerance, int max_iterations,
                    std::span<double> x) {
    std::vector<double> scale;
    return solve(system, b, tolerance, max_iterations, x, scale);
  }
  /// S (b − A x) of the last solve.
  std::span<const double> residual() const { return r_; }
  /// During a solve: true for slices whose island needs no more products.
  bool solved(std::size_t slice) const { return slice < solved_.size() && solved_[slice] != 0; }

 private:
  /// Unknowns of one island that are processed together.
  struct Chunk {
    std::size_t begin, end;
    std::int32_t island;
  };
  struct Island {
    double rz = 0.0, goal = 0.0, step = 0.0, ratio = 0.0;
    bool open = false, stuck = false;
  };
  void find_chunks(const LinearSystem& system, std::size_t n);
  /// a · b of each open island, into `sum_`.
  void dot(std::span<const double> a, std::span<const double> b);
  /// Calls f(island, i) for the unknowns of open islands.
  template <class F>
  void for_open(const F& f) const;
  /// Closes islands that have converged or cannot continue. @return true while some are open
  bool close(const LinearSystem& system);

  std::vector<double> r_, z_, p_, y_;
  std::vector<Chunk> chunks_;
  std::vector<double> part_, sum_;
  std::vector<Island> islands_;
  std::vector<std::uint8_t> solved_;
};

}  // namespace brim
