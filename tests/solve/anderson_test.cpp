#include "brim/solve/anderson.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <random>

namespace brim::anderson_test {
namespace {

/// v ← A v + b, A symmetric with eigenvalues spread from -0.5 to 0.999: plain iterations shrink the last by 1 / 1000.
struct Slow {
  Eigen::MatrixXd A;
  Eigen::VectorXd b, fixed;

  Slow(Eigen::Index n, std::mt19937& rng) {
    std::normal_distribution<double> normal;
    const Eigen::MatrixXd R = Eigen::MatrixXd::NullaryExpr(n, n, [&] { return normal(rng); });
    const Eigen::MatrixXd Q = R.householderQr().householderQ();
    A = Q * Eigen::VectorXd::LinSpaced(n, -0.5, 0.999).asDiagonal() * Q.transpose();
    b = Eigen::VectorXd::NullaryExpr(n, [&] { return normal(rng); });
    fixed = (Eigen::MatrixXd::Identity(n, n) - A).lu().solve(b);
  }
  Eigen::VectorXd operator()(const Eigen::VectorXd& v) const { return A * v + b; }
};

TEST(Anderson, AnAffineMapEndsAfterAsManyStepsAsItHasUnknowns) {
  constexpr unsigned kSeed = 3;
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  constexpr Eigen::Index n = 6;
  const Slow g(n, rng);
  Eigen::VectorXd v = Eigen::VectorXd::Zero(n), plain = v;
  Anderson ahead(n, 8);
  for (int i = 0; i < 2 * n; ++i) ahead.step(v, g(v)), plain = g(plain);
  EXPECT_LT((v - g.fixed).norm(), 1e-5 * g.fixed.norm());
  EXPECT_GT((plain - g.fixed).norm(), 0.5 * g.fixed.norm());
}

TEST(Anderson, AStepThatMakesTheResidualGrowIsTakenBack) {
  Eigen::VectorXd v = Eigen::VectorXd::Zero(2);
  Anderson ahead(2, 4);
  const Eigen::Vector2d first(1.0, 0.0);
  EXPECT_TRUE(ahead.step(v, first));
  EXPECT_EQ(v, first);  // nothing to go by yet: g(v)
  EXPECT_FALSE(ahead.step(v, first + Eigen::Vector2d(0.0, 2.1)));
  EXPECT_EQ(v, first);
  // And is of no account for what follows.
  const Eigen::Vector2d second(1.5, 0.0);
  EXPECT_TRUE(ahead.step(v, second));
  EXPECT_EQ(v, second);
}

TEST(Anderson, WhatStandsStillStays) {
  Eigen::VectorXd v = Eigen::VectorXd::Constant(3, 0.7);
  Anderson ahead(3, 4);
  for (int i = 0; i < 5; ++i) {
    ahead.step(v, Eigen::VectorXd::Constant(3, 0.7));
    EXPECT_EQ(v, Eigen::VectorXd::Constant(3, 0.7));
  }
}

}  // namespace
}  // namespace brim::anderson_test
