#include "brim/body/grid_fluid/grid_poisson.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

namespace brim::grid_poisson_test {
namespace {

constexpr unsigned kSeed = 17;

/// A random wet region whose couplings differ by six orders of magnitude, as a dense matrix too.
struct Problem {
  GridPoisson solver;
  Eigen::MatrixXd dense;
  std::vector<double> b;

  Problem(const Vec3i& n, double wet_share, unsigned seed) {
    std::mt19937 rng(seed);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    const auto cells = static_cast<std::size_t>(n.prod());
    solver.reset(n);
    auto& A = solver.finest();
    std::vector<char> wet(cells);
    for (auto& w : wet) w = unit(rng) < wet_share;
    dense = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(cells), static_cast<Eigen::Index>(cells));
    b.resize(cells);
    const std::array<int, 3> stride = {1, n.x(), n.x() * n.y()};
    for (int k = 0; k < n.z(); ++k)
      for (int j = 0; j < n.y(); ++j)
        for (int i = 0; i < n.x(); ++i) {
          const int c = i + stride[1] * j + stride[2] * k;
          b[c] = wet[c] ? unit(rng) - 0.5 : 0.0;
          const std::array<int, 3> at = {i, j, k};
          for (int a = 0; a < 3; ++a) {
            if (at[a] + 1 >= n[a]) continue;
            const int other = c + stride[a];
            const double weight = std::pow(10.0, -6.0 * unit(rng));
            if (wet[c]) A.diagonal[c] += weight, dense(c, c) += weight;
            if (wet[other]) A.diagonal[other] += weight, dense(other, other) += weight;
            if (wet[c] && wet[other]) A.coupling[a][c] = weight, dense(c, other) = dense(other, c) = -weight;
          }
        }
    for (std::size_t c = 0; c < cells; ++c)
      if (!wet[c]) dense(static_cast<Eigen::Index>(c), static_cast<Eigen::Index>(c)) = 1.0;
    solver.finish();
  }
};

TEST(GridPoisson, SolvesWhatADenseFactorizationSolves) {
  for (unsigned seed = kSeed; seed < kSeed + 5; ++seed) {
    SCOPED_TRACE(seed);
    Problem p({7, 6, 9}, 0.7, seed);
    std::vector<double> x(p.b.size(), 0.0);
    p.solver.solve(p.b, 1e-13, 500, x);
    const Eigen::Map<const Eigen::VectorXd> b(p.b.data(), static_cast<Eigen::Index>(p.b.size()));
    const Eigen::VectorXd exact = p.dense.ldlt().solve(b);
    const Eigen::Map<const Eigen::VectorXd> got(x.data(), b.size());
    EXPECT_LT((p.dense * got - b).cwiseAbs().maxCoeff(), 1e-12);  // rounding of the residual that CG carries along
    EXPECT_LT((got - exact).norm(), 1e-6 * exact.norm());
  }
}

TEST(GridPoisson, IterationsHardlyGrowWithTheGrid) {
  // Laplace's matrix with air above: the pool.
  std::vector<int> iterations;
  for (const int n : {8, 16, 32}) {
    GridPoisson solver;
    solver.reset({n, n, n});
    auto& A = solver.finest();
    for (int k = 0; k < n; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
          const int c = i + n * (j + n * k);
          A.diagonal[c] = (i > 0) + (i + 1 < n) + (j > 0) + (j + 1 < n) + (k > 0) + 1;
          if (i + 1 < n) A.coupling[0][c] = 1.0;
          if (j + 1 < n) A.coupling[1][c] = 1.0;
          if (k + 1 < n) A.coupling[2][c] = 1.0;
        }
    solver.finish();
    std::mt19937 rng(kSeed);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    std::vector<double> b(A.diagonal.size()), x(b.size(), 0.0);
    for (double& e : b) e = unit(rng);
    iterations.push_back(solver.solve(b, 1e-8, 500, x));
  }
  EXPECT_LT(iterations[2], 20);
  EXPECT_LE(iterations[2], 2 * iterations[0]);
}

TEST(GridPoisson, NothingWet_GivesZero) {
  GridPoisson solver;
  solver.reset({5, 5, 5});
  solver.finish();
  std::vector<double> b(125, 1.0), x(125, 3.0);
  EXPECT_EQ(solver.solve(b, 1e-10, 100, x), 0);
  for (const double e : x) EXPECT_EQ(e, 0.0);
}

TEST(GridPoisson, ClosedBoxWithoutAir_IsSolvedUpToAConstant) {
  const int n = 12;
  GridPoisson solver;
  solver.reset({n, 1, 1});
  auto& A = solver.finest();
  for (int i = 0; i < n; ++i) {
    A.diagonal[i] = (i > 0) + (i + 1 < n);
    if (i + 1 < n) A.coupling[0][i] = 1.0;
  }
  solver.finish();
  std::vector<double> b(n, 0.0), x(n, 0.0);
  b.front() = 1.0, b.back() = -1.0;
  solver.solve(b, 1e-12, 200, x);
  for (int i = 0; i + 1 < n; ++i) EXPECT_NEAR(x[i] - x[i + 1], 1.0, 1e-10);
}

}  // namespace
}  // namespace brim::grid_poisson_test
