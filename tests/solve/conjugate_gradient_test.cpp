#include "brim/solve/conjugate_gradient.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <limits>
#include <random>

#include "brim/core/parallel.h"

namespace brim::conjugate_gradient_test {
namespace {

constexpr unsigned kSeed = 51;

/// Random symmetric positive definite system with a diagonal preconditioner and some prescribed directions.
struct Problem {
  Eigen::MatrixXd A;
  Eigen::VectorXd b;
  std::vector<std::size_t> prescribed;
  LinearSystem system;

  explicit Problem(int n) : A(n, n), b(n) {
    std::mt19937 rng(kSeed);
    std::normal_distribution<double> normal;
    Eigen::MatrixXd m(n, n);
    for (double& x : m.reshaped()) x = normal(rng);
    for (double& x : b) x = normal(rng);
    Eigen::VectorXd scale(n);
    for (double& x : scale) x = std::exp(normal(rng));
    A = scale.asDiagonal() * (m * m.transpose() / n + Eigen::MatrixXd::Identity(n, n)) * scale.asDiagonal();
    system.apply = [this](std::span<const double> x, std::span<double> y) {
      Eigen::Map<Eigen::VectorXd>(y.data(), y.size()) = A * Eigen::Map<const Eigen::VectorXd>(x.data(), x.size());
    };
    system.precondition = [this](std::span<const double> r, std::span<double> z) {
      for (std::size_t i = 0; i < r.size(); ++i) z[i] = r[i] / A(i, i);
    };
    system.filter = [this](std::span<double> x) {
      for (const std::size_t i : prescribed) x[i] = 0.0;
    };
  }
};

std::span<double> view(Eigen::VectorXd& x) { return {x.data(), static_cast<std::size_t>(x.size())}; }

TEST(ConjugateGradient, TwoUnknownsByHandInTwoIterations) {
  Problem p(2);
  p.A << 4, 1, 1, 3;
  p.b << 1, 2;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(2);
  const SolveReport r = ConjugateGradient().solve(p.system, view(p.b), 1e-12, 10, view(x));
  EXPECT_LE(r.iterations, 2);
  EXPECT_TRUE(r.converged);
  EXPECT_NEAR(x[0], 1.0 / 11.0, 1e-14);
  EXPECT_NEAR(x[1], 7.0 / 11.0, 1e-14);
}

TEST(ConjugateGradient, AScaleFromBeforeSavesAPreconditioningAndTellsWhenToStop) {
  SCOPED_TRACE(kSeed);
  Problem p(120);
  Eigen::VectorXd first = Eigen::VectorXd::Zero(120);
  ConjugateGradient cg;
  std::vector<double> scale;
  cg.solve(p.system, view(p.b), 1e-2, 1000, view(first), scale);
  int preconditionings = 0;
  const auto precondition = p.system.precondition;
  p.system.precondition = [&](std::span<const double> r, std::span<double> z) {
    ++preconditionings, precondition(r, z);
  };
  Eigen::VectorXd alone = first, told = first;
  const SolveReport a = cg.solve(p.system, view(p.b), 1e-8, 1000, view(alone));
  EXPECT_EQ(preconditionings, a.iterations + 2);
  preconditionings = 0;
  const SolveReport b = cg.solve(p.system, view(p.b), 1e-8, 1000, view(told), scale);
  EXPECT_EQ(preconditionings, b.iterations + 1);
  EXPECT_EQ(alone, told);
  EXPECT_EQ(a.residual, b.residual);
}

TEST(ConjugateGradient, EqualsAFactorisationOnARandomSystem) {
  SCOPED_TRACE(kSeed);
  Problem p(120);
  const Eigen::VectorXd expected = p.A.llt().solve(p.b);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(120);
  const SolveReport r = ConjugateGradient().solve(p.system, view(p.b), 1e-12, 1000, view(x));
  EXPECT_TRUE(r.converged);
  EXPECT_TRUE(r.finite);
  EXPECT_LT((x - expected).norm(), 1e-10 * expected.norm());
  // The reported residual is that of the preconditioner's norm.
  const Eigen::VectorXd residual = p.b - p.A * x, d = p.A.diagonal();
  const double true_residual = std::sqrt(residual.cwiseQuotient(d).dot(residual) / p.b.cwiseQuotient(d).dot(p.b));
  EXPECT_NEAR(r.residual, true_residual, 1e-13);
}

TEST(ConjugateGradient, StopsAtTheAskedResidualAndAtTheIterationLimit) {
  Problem p(120);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(120);
  const SolveReport loose = ConjugateGradient().solve(p.system, view(p.b), 1e-3, 1000, view(x));
  EXPECT_TRUE(loose.converged);
  EXPECT_LE(loose.residual, 1e-3);
  EXPECT_GT(loose.residual, 1e-6);
  x.setZero();
  const SolveReport cut = ConjugateGradient().solve(p.system, view(p.b), 1e-12, 3, view(x));
  EXPECT_EQ(cut.iterations, 3);
  EXPECT_FALSE(cut.converged);
  EXPECT_TRUE(cut.finite);
}

TEST(ConjugateGradient, ImposedDirectionsStayZeroAndTheRestSolvesTheReducedSystem) {
  SCOPED_TRACE(kSeed);
  Problem p(40);
  p.prescribed = {0, 7, 8, 39};
  std::vector<int> free;
  for (int i = 0; i < 40; ++i)
    if (std::find(p.prescribed.begin(), p.prescribed.end(), static_cast<std::size_t>(i)) == p.prescribed.end())
      free.push_back(i);
  const Eigen::MatrixXd reduced = p.A(free, free);
  const Eigen::VectorXd expected = reduced.llt().solve(Eigen::VectorXd(p.b(free)));
  for (const bool warm : {false, true}) {
    Eigen::VectorXd x = warm ? Eigen::VectorXd::Ones(40) : Eigen::VectorXd::Zero(40);
    const SolveReport r = ConjugateGradient().solve(p.system, view(p.b), 1e-12, 1000, view(x));
    EXPECT_TRUE(r.converged);
    for (const std::size_t i : p.prescribed) EXPECT_EQ(x[i], 0.0);
    EXPECT_LT((Eigen::VectorXd(x(free)) - expected).norm(), 1e-10 * expected.norm());
  }
}

TEST(ConjugateGradient, IdleUnknownsStayZeroAndChangeNothing) {
  SCOPED_TRACE(kSeed);
  Problem p(120);
  for (std::size_t i = 30; i < 90; ++i) p.prescribed.push_back(i);
  Eigen::VectorXd all = Eigen::VectorXd::Zero(120), some = Eigen::VectorXd::Ones(120);
  ConjugateGradient().solve(p.system, view(p.b), 1e-13, 500, view(all));
  const std::array<std::size_t, 2> idle[] = {{30, 50}, {50, 90}};
  p.system.idle = idle;
  ConjugateGradient cg;
  cg.solve(p.system, view(p.b), 1e-13, 500, view(some));
  EXPECT_LT((some - all).cwiseAbs().maxCoeff(), 1e-10 * all.cwiseAbs().maxCoeff());
  for (std::size_t i = 30; i < 90; ++i) {
    EXPECT_EQ(some[static_cast<Eigen::Index>(i)], 0.0);
    EXPECT_EQ(cg.residual()[i], 0.0);
  }
}

TEST(ConjugateGradient, StartingFromTheSolutionTakesNoIteration) {
  Problem p(60);
  Eigen::VectorXd x = p.A.llt().solve(p.b);
  const SolveReport r = ConjugateGradient().solve(p.system, view(p.b), 1e-10, 1000, view(x));
  EXPECT_EQ(r.iterations, 0);
  EXPECT_TRUE(r.converged);
}

TEST(ConjugateGradient, ARightHandSideThatChangesNothingIsNotResolved) {
  Problem p(40);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(40), exact = p.A.ldlt().solve(p.b);
  double negligible = 0.25 * exact.dot(p.A * exact);
  p.system.negligible = {&negligible, 1};
  const int partly = ConjugateGradient().solve(p.system, view(p.b), 1e-12, 200, view(x)).iterations;
  EXPECT_GT(partly, 0);
  negligible = 0.0;
  x.setZero();
  EXPECT_GT(ConjugateGradient().solve(p.system, view(p.b), 1e-12, 200, view(x)).iterations, partly);
  p.b *= 1e-9;  // rounding, beside what counts
  negligible = 1e-14 * exact.dot(p.A * exact);
  x.setZero();
  const SolveReport r = ConjugateGradient().solve(p.system, view(p.b), 1e-12, 200, view(x));
  EXPECT_EQ(r.iterations, 0);
  EXPECT_TRUE(r.converged);
}

TEST(ConjugateGradient, ZeroRightHandSideGivesZero) {
  Problem p(10);
  p.b.setZero();
  Eigen::VectorXd x = Eigen::VectorXd::Ones(10);
  const SolveReport r = ConjugateGradient().solve(p.system, view(p.b), 1e-8, 100, view(x));
  EXPECT_TRUE(r.converged);
  EXPECT_EQ(r.iterations, 0);
  EXPECT_EQ(x.norm(), 0.0);
}

TEST(ConjugateGradient, AnIslandIsSolvedAsIfItWereAloneHoweverHardOthersArePushed) {
  SCOPED_TRACE(kSeed);
  // Unknowns 0 to 29 and 50 to 79 are one, 30 to 49 another, of which the first is pushed a million times as hard; its
  // preconditioner is exact.
  Problem p(80);
  const auto in_one = [](int i) { return i < 30 || i >= 50; };
  for (int i = 0; i < 80; ++i)
    for (int j = 0; j < 80; ++j)
      if (i != j && (in_one(i) || in_one(j))) p.A(i, j) = 0.0;
  for (int i = 0; i < 80; ++i)
    if (in_one(i)) p.b[i] *= 1e6;
  Eigen::VectorXd light = p.b, alone = Eigen::VectorXd::Zero(80), together = alone, mixed = alone;
  for (int i = 0; i < 80; ++i)
    if (in_one(i)) light[i] = 0.0;
  const std::vector<std::size_t> first = {0, 30, 50, 80};
  const std::vector<std::int32_t> island = {0, 1, 0};
  LinearSystem system = p.system;
  ConjugateGradient cg;
  cg.solve(p.system, view(p.b), 1e-3, 1000, view(mixed));
  cg.solve(p.system, view(light), 1e-3, 1000, view(alone));
  int left_out = 0;
  system.first = first, system.island = island;
  system.apply = [&](std::span<const double> x, std::span<double> y) {
    p.system.apply(x, y);
    EXPECT_EQ(cg.solved(0), cg.solved(2));
    for (int i = 30; i < 50 && cg.solved(1); ++i) y[i] = std::numeric_limits<double>::quiet_NaN(), left_out = 1;
    for (int i = 0; i < 80 && cg.solved(0); ++i)
      if (in_one(i)) y[i] = std::numeric_limits<double>::quiet_NaN(), left_out = 1;
  };
  const SolveReport r = cg.solve(system, view(p.b), 1e-3, 1000, view(together));
  EXPECT_TRUE(r.converged && r.finite);
  EXPECT_LE(r.residual, 1e-3);
  EXPECT_EQ(left_out, 1) << "one of them takes fewer iterations";
  EXPECT_FALSE(cg.solved(0) || cg.solved(1)) << "after the solve all count again";
  const Eigen::VectorXd exact = p.A.ldlt().solve(p.b);
  const auto error = [&](const Eigen::VectorXd& x) {
    return (x - exact).segment(30, 20).norm() / exact.segment(30, 20).norm();
  };
  for (int i = 30; i < 50; ++i) EXPECT_NEAR(together[i], alone[i], 1e-12 * exact.segment(30, 20).norm());
  EXPECT_LT(error(together), 1e-2);
  EXPECT_GT(error(mixed), 1e2 * error(together)) << "what one tolerance for both would leave";
}

/// As a factor in single precision of a matrix of large condition is: its two passes round, each in its own way.
TEST(ConjugateGradient, APreconditionerThatIsNotQuiteSymmetricDoesNotHoldItUp) {
  SCOPED_TRACE(kSeed);
  Problem p(80);
  std::mt19937 rng(kSeed);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd skew = Eigen::MatrixXd::Zero(80, 80);
  for (int i = 0; i < 80; ++i)
    for (int j = 0; j < i; ++j) skew(i, j) = 0.02 * normal(rng), skew(j, i) = -skew(i, j);
  const Eigen::MatrixXd half = p.A.inverse().llt().matrixL();
  const Eigen::MatrixXd P = half * (Eigen::MatrixXd::Identity(80, 80) + skew) * half.transpose();
  p.system.precondition = [&](std::span<const double> r, std::span<double> z) {
    Eigen::Map<Eigen::VectorXd>(z.data(), z.size()) = P * Eigen::Map<const Eigen::VectorXd>(r.data(), r.size());
  };
  Eigen::VectorXd x = Eigen::VectorXd::Zero(80);
  const SolveReport r = ConjugateGradient().solve(p.system, view(p.b), 1e-10, 2000, view(x));
  EXPECT_TRUE(r.converged);
  EXPECT_LT(r.iterations, 200);
}

TEST(ConjugateGradient, ReportsValuesThatAreNotFinite) {
  Problem p(10);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(10);
  p.b[4] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(ConjugateGradient().solve(p.system, view(p.b), 1e-8, 100, view(x)).finite);
  Problem broken(10);
  broken.A(3, 2) = std::numeric_limits<double>::quiet_NaN();
  x.setZero();
  const SolveReport r = ConjugateGradient().solve(broken.system, view(broken.b), 1e-8, 100, view(x));
  EXPECT_FALSE(r.finite && r.converged);
  EXPECT_FALSE(r.finite) << "a matrix that is not finite is not a mere failure to converge";
}

TEST(ConjugateGradient, AnyNumberOfThreadsGivesTheSameBits) {
  constexpr std::size_t kRows = 100000;  // several blocks of every parallel loop
  LinearSystem chain;
  chain.apply = [](std::span<const double> x, std::span<double> y) {
    parallel_for(
        x.size(),
        [&](std::size_t i) {
          y[i] = (2.01 + 1e-5 * static_cast<double>(i)) * x[i] - (i > 0 ? x[i - 1] : 0.0) -
                 (i + 1 < x.size() ? x[i + 1] : 0.0);
        },
        512);
  };
  chain.precondition = [](std::span<const double> r, std::span<double> z) { std::copy(r.begin(), r.end(), z.begin()); };
  chain.filter = [](std::span<double>) {};
  std::vector<double> b(kRows), one;
  std::mt19937 rng(kSeed);
  std::normal_distribution<double> normal;
  for (double& e : b) e = normal(rng);
  for (const int threads : {1, 2, 4}) {
    const ThreadLimit limit(threads);
    std::vector<double> x(kRows, 0.0);
    const SolveReport r = ConjugateGradient().solve(chain, b, 1e-6, 500, x);
    EXPECT_GT(r.iterations, 5);
    if (threads == 1) one = x;
    EXPECT_EQ(x, one) << threads << " threads";
  }
}

}  // namespace
}  // namespace brim::conjugate_gradient_test
