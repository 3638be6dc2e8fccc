#pragma once

#include <functional>
#include <span>
#include <vector>

namespace brim {

/// What the solver needs of a linear system; it knows nothing of bodies (paper, section 6).
struct LinearSystem {
  std::function<void(std::span<const double> x, std::span<double> y)> apply;         ///< y = A x
  std::function<void(std::span<const double> r, std::span<double> z)> precondition;  ///< z = P⁻¹ r
  std::function<void(std::span<double> x)> filter;                                   ///< zero in the imposed directions
  double negligible = 0.0;  ///< xᵀ A x below which a solution changes nothing that counts, and any guess is good
};

struct SolveReport {
  int iterations = 0;
  double residual = 0.0;  ///< |S(b − A x)| over |S b| in the preconditioner's norm
  double scale = 0.0;     ///< |S b|² in that norm
  bool converged = false;
  bool finite = true;
};

/// Solves S A S x = S b by preconditioned conjugate gradient, S the filter (Baraff and Witkin 1998, section 5.3; here
/// the imposed directions of x are zero). Vectors are kept between calls.
class ConjugateGradient {
 public:
  /// @param x      first guess on entry, solution on return; filtered
  /// @param scale  what counts as |S b|², from an earlier solve of nearly the same system; 0: found here
  /// Same bits for any number of threads.
  SolveReport solve(const LinearSystem& system, std::span<const double> b, double tolerance, int max_iterations,
                    std::span<double> x, double scale = 0.0);
  /// S (b − A x) of the last solve.
  std::span<const double> residual() const { return r_; }

 private:
  std::vector<double> r_, z_, p_, y_;
};

}  // namespace brim
