#include "brim/solve/block_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "brim/core/parallel.h"

namespace brim::block_cholesky_test {
namespace {

/// What entries below the diagonal in 1,023 steps leave of a solution, with the condition of the matrices here.
constexpr double kTenBits = 6e-3;
constexpr unsigned kSeed = 11;

/// Random sparse definite matrix: a chain of blocks, and links across it.
struct Problem {
  std::vector<std::int32_t> first{0}, column;
  std::vector<BlockCholesky::Block> value;
  Eigen::MatrixXd dense;

  Problem(int n, int links, double shift) {
    std::mt19937 rng(kSeed);
    std::normal_distribution<double> normal;
    std::uniform_int_distribution<int> node(0, n - 1);
    dense = Eigen::MatrixXd::Zero(3 * n, 3 * n);
    std::vector<std::vector<std::int32_t>> row(n);
    const auto couple = [&](int i, int j) {
      // A stiff spring in a random direction, as a contact is.
      Eigen::Vector3d d(normal(rng), normal(rng), normal(rng));
      const Eigen::Matrix3d k = d * d.transpose() + 0.1 * Eigen::Matrix3d::Identity();
      dense.block<3, 3>(3 * i, 3 * i) += k;
      dense.block<3, 3>(3 * j, 3 * j) += k;
      dense.block<3, 3>(3 * i, 3 * j) -= k;
      dense.block<3, 3>(3 * j, 3 * i) -= k;
      row[std::min(i, j)].push_back(std::max(i, j));
    };
    for (int i = 0; i + 1 < n; ++i) couple(i, i + 1);
    for (int l = 0; l < links; ++l)
      if (const int i = node(rng), j = node(rng); i != j) couple(i, j);
    dense += shift * Eigen::MatrixXd::Identity(3 * n, 3 * n);
    for (int i = 0; i < n; ++i) {
      row[i].push_back(i);
      std::sort(row[i].begin(), row[i].end());
      row[i].erase(std::unique(row[i].begin(), row[i].end()), row[i].end());
      for (const std::int32_t j : row[i]) {
        column.push_back(j);
        value.push_back(dense.block<3, 3>(3 * i, 3 * j).cast<float>());
      }
      first.push_back(static_cast<std::int32_t>(column.size()));
    }
  }
};

double error_of(BlockCholesky& factor, const Problem& p) {
  const Eigen::VectorXd b = Eigen::VectorXd::Random(p.dense.rows());
  std::vector<float> x(static_cast<std::size_t>(b.size()));
  for (Eigen::Index i = 0; i < b.size(); ++i) x[i] = static_cast<float>(b[i]);
  factor.solve(x);
  const Eigen::VectorXd exact = p.dense.llt().solve(b);
  Eigen::VectorXd got(b.size());
  for (Eigen::Index i = 0; i < b.size(); ++i) got[i] = x[i];
  return (got - exact).norm() / exact.norm();
}

TEST(BlockCholesky, EqualsADenseSolveOnRandomPatterns) {
  SCOPED_TRACE(kSeed);
  for (const int n : {1, 2, 5, 40, 150})
    for (const int links : {0, n / 4, n, 4 * n}) {
      const Problem p(n, links, 0.5);
      BlockCholesky factor;
      factor.analyze(p.first, p.column);
      EXPECT_EQ(factor.factor(p.value), 0);
      // Single precision times the condition of the matrix.
      EXPECT_LT(error_of(factor, p), 3e-5) << n << " blocks, " << links << " links";
    }
}

TEST(BlockCholesky, TakesNewValuesWithTheOldStructure) {
  const Problem soft(60, 60, 0.5), stiff(60, 60, 5.0);
  BlockCholesky factor;
  factor.analyze(soft.first, soft.column);
  factor.factor(soft.value);
  factor.factor(stiff.value);
  EXPECT_LT(error_of(factor, stiff), 1e-5);
}

TEST(BlockCholesky, StaysDefiniteWhereTheMatrixIsSingular) {
  const Problem p(30, 20, 0.0);  // translations cost nothing
  BlockCholesky factor;
  factor.analyze(p.first, p.column);
  EXPECT_GT(factor.factor(p.value), 0);
  Eigen::MatrixXd inverse(90, 90);
  for (int k = 0; k < 90; ++k) {
    std::vector<float> x(90, 0.0f);
    x[k] = 1.0f;
    factor.solve(x);
    for (int i = 0; i < 90; ++i) inverse(i, k) = x[i];
  }
  const Eigen::MatrixXd symmetric = 0.5 * (inverse + inverse.transpose());
  EXPECT_LT((inverse - symmetric).norm(), 1e-3 * symmetric.norm());
  EXPECT_GT(symmetric.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), 0.0);
}

/// A square lattice of nodes, each coupled to its neighbours: a sheet, whose elimination tree has many branches.
struct Lattice {
  std::vector<std::int32_t> first{0}, column;
  std::vector<BlockCholesky::Block> value;

  explicit Lattice(int side) {
    const BlockCholesky::Block one = BlockCholesky::Block::Identity();
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        const std::int32_t i = y * side + x;
        const auto add = [&](std::int32_t j, const BlockCholesky::Block& b) {
          column.push_back(j), value.push_back(b);
        };
        BlockCholesky::Block own = 4.5f * one;
        own(0, 1) = own(1, 0) = 0.3f;
        add(i, own);
        if (x + 1 < side) add(i + 1, -one);
        if (y + 1 < side) add(i + side, -one);
        first.push_back(static_cast<std::int32_t>(column.size()));
      }
  }
  Eigen::VectorXd times(std::span<const float> x) const {
    Eigen::VectorXd y = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(x.size()));
    const auto at = [&](std::int32_t i) { return Eigen::Vector3d(x[3 * i], x[3 * i + 1], x[3 * i + 2]); };
    for (std::int32_t r = 0; r + 1 < static_cast<std::int32_t>(first.size()); ++r)
      for (std::int32_t e = first[r]; e < first[r + 1]; ++e) {
        y.segment<3>(3 * r) += value[e].cast<double>() * at(column[e]);
        if (column[e] != r) y.segment<3>(3 * column[e]) += value[e].transpose().cast<double>() * at(r);
      }
    return y;
  }
};

/// The answer to a ramp of loads, by as many threads.
std::vector<float> answer(BlockCholesky& factor, const Lattice& p, int threads) {
  const ThreadLimit limit(threads);
  factor.analyze(p.first, p.column);
  EXPECT_EQ(factor.factor(p.value), 0);
  std::vector<float> x(3 * factor.blocks());
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = 1.0f + 0.001f * static_cast<float>(i % 97);
  factor.solve(x);
  return x;
}

TEST(BlockCholesky, BranchesSharedByThreadsGiveTheSameBits) {
  // Large ones are divided into tasks, and rows of the largest panels of what lies above them are shared, of small ones
  // neither: one object takes all in turn.
  BlockCholesky one, two;
  for (const int side : {48, 5, 60, 110}) {
    const Lattice p(side);
    const std::vector<float> x = answer(one, p, 1);
    EXPECT_EQ(x, answer(two, p, 2)) << side;
    Eigen::VectorXd b(static_cast<Eigen::Index>(x.size()));
    for (Eigen::Index i = 0; i < b.size(); ++i) b[i] = 1.0f + 0.001f * static_cast<float>(i % 97);
    // Large factors are read in ten bits.
    EXPECT_LT((p.times(x) - b).norm(), (one.entries() > 200000 ? kTenBits : 1e-5) * b.norm()) << side;
  }
}

}  // namespace
}  // namespace brim::block_cholesky_test
