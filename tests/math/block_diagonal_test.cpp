#include "brim/math/block_diagonal.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "brim/core/parallel.h"

namespace brim::block_diagonal_test {
namespace {

constexpr unsigned kSeed = 33;

struct RandomBlocks {
  std::vector<int> sizes;
  BlockDiagonal D;
  std::vector<double> r;

  explicit RandomBlocks(std::size_t count) {
    std::mt19937 rng(kSeed);
    std::uniform_int_distribution<int> size(1, 9);
    std::normal_distribution<double> normal;
    for (std::size_t b = 0; b < count; ++b) sizes.push_back(b % 3 == 0 ? 3 : b % 3 == 1 ? 6 : size(rng));
    D.reset(sizes);
    for (std::size_t b = 0; b < count; ++b) {
      Eigen::MatrixXd m(sizes[b], sizes[b]);
      for (double& x : m.reshaped()) x = normal(rng);
      D.block(b) += m * m.transpose() + 0.1 * Eigen::MatrixXd::Identity(sizes[b], sizes[b]);
    }
    for (std::size_t i = 0; i < D.rows(); ++i) r.push_back(normal(rng));
  }
};

TEST(BlockDiagonal, SolvesTwoBlocksByHand) {
  BlockDiagonal D;
  D.reset(std::vector<int>{1, 2});
  ASSERT_EQ(D.rows(), 3u);
  EXPECT_EQ(D.block_row(1), 1u);
  D.block(0)(0, 0) = 4.0;
  D.block(1) << 2, 1, 1, 2;
  D.factor();
  std::vector<double> z(3);
  D.solve(std::vector<double>{8, 3, 0}, z);
  EXPECT_NEAR(z[0], 2.0, 1e-15);
  EXPECT_NEAR(z[1], 2.0, 1e-15);
  EXPECT_NEAR(z[2], -1.0, 1e-15);
}

TEST(BlockDiagonal, SolveEqualsADenseSolverForBlocksOfAnySize) {
  SCOPED_TRACE(kSeed);
  RandomBlocks blocks(200);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(blocks.D.rows(), blocks.D.rows());
  for (std::size_t b = 0; b < blocks.D.block_count(); ++b) {
    ASSERT_EQ(blocks.D.block_size(b), blocks.sizes[b]);
    dense.block(blocks.D.block_row(b), blocks.D.block_row(b), blocks.sizes[b], blocks.sizes[b]) = blocks.D.block(b);
  }
  std::vector<double> z(blocks.r.size());
  blocks.D.factor();
  blocks.D.solve(blocks.r, z);
  const Eigen::Map<const Eigen::VectorXd> r(blocks.r.data(), blocks.r.size()), x(z.data(), z.size());
  const Eigen::VectorXd expected = dense.fullPivLu().solve(r);
  // Conditions reach 1e3 (0.1 on the diagonal): 1e-16 * 1e3 and a margin.
  EXPECT_LT((x - expected).norm(), 1e-11 * expected.norm());
}

TEST(BlockDiagonal, ABlockThatIsNotDefiniteIsReplacedByItsDiagonal) {
  BlockDiagonal D;
  D.reset(std::vector<int>{2, 3});
  D.block(0) << -2, 9, 9, 4;
  D.factor();  // the second block is zero
  std::vector<double> z(5);
  D.solve(std::vector<double>{2, 4, 1, 2, 3}, z);
  EXPECT_EQ(z, (std::vector<double>{1, 1, 1, 2, 3}));
}

TEST(BlockDiagonal, NoBlocksAreNoRows) {
  BlockDiagonal D;
  D.reset({});
  D.factor();
  D.solve({}, {});
  EXPECT_EQ(D.rows(), 0u);
}

TEST(BlockDiagonal, ResetForgetsEverything) {
  RandomBlocks blocks(5);
  blocks.D.reset(blocks.sizes);
  for (std::size_t b = 0; b < 5; ++b) EXPECT_EQ(blocks.D.block(b).norm(), 0.0);
}

TEST(BlockDiagonal, AnyNumberOfThreadsGivesTheSameBits) {
  std::vector<double> one, z;
  for (const int threads : {1, 2, 4}) {
    const ThreadLimit limit(threads);
    RandomBlocks blocks(5000);
    z.assign(blocks.r.size(), 0.0);
    blocks.D.factor();
    blocks.D.solve(blocks.r, z);
    if (threads == 1) one = z;
    EXPECT_EQ(z, one) << threads << " threads";
  }
}

}  // namespace
}  // namespace brim::block_diagonal_test
