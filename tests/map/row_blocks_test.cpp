#include "brim/map/row_blocks.h"

#include <gtest/gtest.h>

#include <random>

namespace brim::row_blocks_test {
namespace {

using Block = RowBlocks::Block;

Block random_block(std::mt19937& rng) {
  std::normal_distribution<float> normal;
  Block b;
  for (int i = 0; i < 9; ++i) b.data()[i] = normal(rng);
  return b;
}

TEST(RowBlocks, MultiplyAsTheBlocksTheyStandFor) {
  std::mt19937 rng(5);
  RowBlocks blocks, turned;
  std::vector<Block> dense;
  for (int i = 0; i < 20; ++i) {
    const Block J = random_block(rng);
    if (i % 3 == 0)
      blocks.add(J), dense.push_back(J);
    else
      blocks.add(J(0, 0)), dense.push_back(J(0, 0) * Block::Identity());
  }
  turned.resize(dense.size(), static_cast<std::size_t>(blocks.general(0, dense.size())));
  std::int32_t next = 0;
  for (std::size_t e = 0; e < dense.size(); ++e) turned.put(e, next, blocks, e, -1.0f);
  ASSERT_EQ(blocks.size(), dense.size());
  for (std::size_t e = 0; e < dense.size(); ++e) {
    const Block K = random_block(rng), &J = dense[e];
    EXPECT_EQ(blocks[e], J);
    EXPECT_EQ(turned[e], Block(-J));
    EXPECT_LT((blocks.transposed_times(e, K) - J.transpose() * K).norm(), 1e-5f);
    EXPECT_LT((blocks.times(K, e) - K * J).norm(), 1e-5f);
    EXPECT_NEAR(blocks.trace(e, K), (J.transpose() * K * J).trace(), 1e-4f);
  }
  blocks.clear();
  EXPECT_EQ(blocks.size(), 0u);
}

}  // namespace
}  // namespace brim::row_blocks_test
