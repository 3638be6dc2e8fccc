#pragma once

#include <Eigen/Core>
#include <vector>

namespace brim {

/// Cholesky factor of a dense symmetric matrix in single precision, with wide instructions: for self-correcting
/// iterations. Half the bytes of double, and no divisions when applied.
/// Same bits for any machine.  Tests: tests/solve/dense_factor_test.cpp
class DenseFactor {
 public:
  /// Factors A + shift 1. @param A  shape (n, n), n a multiple of 3, symmetric; its diagonal about 1
  /// @return false when single precision is not enough: pivots were raised
  bool factor(const Eigen::MatrixXd& A, double shift);
  /// x = (A + shift 1)⁻¹ b. @param b, x  shape (n); may be the same
  void solve(const Eigen::VectorXd& b, Eigen::VectorXd& x);

 private:
  std::size_t n_ = 0, stride_ = 0;
  std::vector<float> panel_, workspace_, x_;
};

}  // namespace brim
