#include "brim/solve/dense_factor.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

namespace brim::dense_factor_test {
namespace {

/// Symmetric, semidefinite, its diagonal about 1.
Eigen::MatrixXd random_matrix(int n, std::mt19937& rng) {
  std::normal_distribution<double> normal;
  const Eigen::MatrixXd B = Eigen::MatrixXd::NullaryExpr(n, n, [&] { return normal(rng); });
  return B * B.transpose() / n;
}

TEST(DenseFactor, SolvesAsADoubleFactorDoesToSinglePrecision) {
  std::mt19937 rng(3);
  // Less than a block of columns, whole blocks, and some more; rows that fill their last lanes and that do not.
  for (const int n : {3, 12, 15, 48, 99, 240}) {
    const Eigen::MatrixXd A = random_matrix(n, rng);
    const double shift = 0.1;
    DenseFactor factor;
    ASSERT_TRUE(factor.factor(A, shift));
    const Eigen::VectorXd b = Eigen::VectorXd::NullaryExpr(n, [&] { return std::normal_distribution<double>()(rng); });
    Eigen::VectorXd x;
    factor.solve(b, x);
    const Eigen::MatrixXd shifted = A + shift * Eigen::MatrixXd::Identity(n, n);
    const Eigen::VectorXd exact = shifted.llt().solve(b);
    EXPECT_LT((x - exact).norm(), 2e-5 * exact.norm()) << n;
    EXPECT_LT((shifted * x - b).norm(), 1e-5 * b.norm()) << n;
  }
}

TEST(DenseFactor, MayBeUsedForItsOwnRightHandSideAndAnotherMatrix) {
  std::mt19937 rng(4);
  DenseFactor factor;
  for (const int n : {60, 21}) {
    const Eigen::MatrixXd A = random_matrix(n, rng);
    ASSERT_TRUE(factor.factor(A, 1.0));
    Eigen::VectorXd x = Eigen::VectorXd::Ones(n);
    factor.solve(x, x);
    EXPECT_LT((A * x + x - Eigen::VectorXd::Ones(n)).norm(), 1e-5 * std::sqrt(n));
  }
}

TEST(DenseFactor, SaysWhereAMatrixIsTooNearToASingularOne) {
  DenseFactor factor;
  EXPECT_FALSE(factor.factor(Eigen::MatrixXd::Ones(9, 9), 1e-9));
  EXPECT_TRUE(factor.factor(Eigen::MatrixXd::Ones(9, 9), 1e-2));
}

}  // namespace
}  // namespace brim::dense_factor_test
