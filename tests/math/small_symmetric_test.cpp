#include "brim/math/small_symmetric.h"

#include <gtest/gtest.h>

#include <random>

namespace brim::small_symmetric_test {
namespace {

constexpr unsigned kSeed = 5;

/// Mᵀ M + share 1 of random M.
Eigen::MatrixXd definite(int n, std::mt19937& rng, double share) {
  std::normal_distribution<double> normal;
  const Eigen::MatrixXd m = Eigen::MatrixXd::NullaryExpr(n, n, [&] { return normal(rng); });
  return m.transpose() * m + share * Eigen::MatrixXd::Identity(n, n);
}

TEST(SmallSymmetric, AxesAreAnAscendingOrthonormalDecomposition) {
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  for (int trial = 0; trial < 20; ++trial) {
    Mat3 m = definite(3, rng, 0.0);
    m -= 0.5 * m.trace() * Mat3::Identity();  // negative ones too
    const SymmetricAxes a = symmetric_axes(m);
    EXPECT_LE(a.values[0], a.values[1]);
    EXPECT_LE(a.values[1], a.values[2]);
    EXPECT_LT((a.vectors.transpose() * a.vectors - Mat3::Identity()).norm(), 1e-14);
    EXPECT_LT((a.vectors * a.values.asDiagonal() * a.vectors.transpose() - m).norm(), 1e-13 * m.norm());
  }
}

TEST(SmallSymmetric, Solves) {
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  for (int trial = 0; trial < 20; ++trial) {
    const Mat3 m = definite(3, rng, 0.1);
    const Vec3 x(1.0, -2.0, 0.5);
    EXPECT_LT((solve_symmetric(m, m * x) - x).norm(), 1e-12);
  }
}

TEST(SmallSymmetric, InvertsDefiniteMatricesOfEverySize) {
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  for (int n = 1; n <= 6; ++n) {
    const Eigen::MatrixXd m = definite(n, rng, 0.1);
    SmallMatrix inverse = m;
    EXPECT_GT(invert_definite(inverse), 0.0) << n;
    EXPECT_LT((inverse * m - Eigen::MatrixXd::Identity(n, n)).norm(), 1e-11) << n;
  }
}

TEST(SmallSymmetric, SaysThatAMatrixIsNotDefinite) {
  SmallMatrix one(1, 1), two(2, 2), nothing = SmallMatrix::Zero(3, 3);
  one << -1.0;
  two << 1.0, 2.0, 2.0, 1.0;
  for (SmallMatrix m : {one, two, nothing}) {
    const SmallMatrix before = m;
    EXPECT_LE(invert_definite(m), 0.0);
    EXPECT_EQ(m, before);
  }
}

TEST(SmallSymmetric, TellsHowNearAMatrixIsToSingular) {
  SmallMatrix m(2, 2);
  m << 1.0, 1.0, 1.0, 1.0 + 1e-8;
  EXPECT_NEAR(invert_definite(m), 1e-8, 1e-9);
}

}  // namespace
}  // namespace brim::small_symmetric_test
