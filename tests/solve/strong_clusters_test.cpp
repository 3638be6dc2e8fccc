#include "brim/solve/strong_clusters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

namespace brim::testing::strong_clusters_test {
namespace {

constexpr unsigned kSeed = 5;
using Numbers = std::vector<std::int32_t>;

TEST(StrongClusters, JoinTheStrongestFirst) {
  // A chain 0 - 1 - 2 - 3 - 4 - 5 that is weak between 1 and 2 and weaker between 3 and 4.
  const std::vector<Coupling> chain = {{0, 1, 1.0f}, {1, 2, 0.3f}, {2, 3, 0.9f}, {3, 4, 0.1f}, {4, 5, 0.5f}};
  EXPECT_EQ(strong_clusters(6, chain, 2), (Numbers{0, 0, 1, 1, 2, 2}));
  EXPECT_EQ(strong_clusters(6, chain, 3), (Numbers{0, 0, 1, 1, 2, 2}));
  EXPECT_EQ(strong_clusters(6, chain, 4), (Numbers{0, 0, 0, 0, 1, 1}));
  EXPECT_EQ(strong_clusters(6, chain, 6), (Numbers{0, 0, 0, 0, 0, 0}));
}

TEST(StrongClusters, CountClustersInTheOrderOfTheirFirstRows) {
  EXPECT_EQ(strong_clusters(5, std::vector<Coupling>{{1, 4, 1.0f}, {2, 3, 2.0f}}, 2), (Numbers{0, 1, 2, 2, 1}));
  EXPECT_EQ(strong_clusters(3, {}, 2), (Numbers{0, 1, 2}));
  EXPECT_TRUE(strong_clusters(0, {}, 2).empty());
}

TEST(StrongClusters, KeepTogetherWhatIsJoinedWhateverItsSize) {
  const std::vector<Coupling> joined = {{0, 2, 0.0f}, {2, 3, 0.0f}}, other = {{0, 1, 5.0f}, {1, 4, 1.0f}};
  EXPECT_EQ(strong_clusters(5, other, 2, joined), (Numbers{0, 1, 0, 0, 1}));
}

TEST(StrongClusters, TakeEqualOnesInTheirOrder) {
  EXPECT_EQ(strong_clusters(3, std::vector<Coupling>{{1, 2, 1.0f}, {0, 1, 1.0f}}, 2), (Numbers{0, 1, 1}));
  EXPECT_EQ(strong_clusters(3, std::vector<Coupling>{{0, 1, 1.0f}, {1, 2, 1.0f}}, 2), (Numbers{0, 0, 1}));
}

TEST(StrongClusters, GrowUntilNoTwoThatAreCoupledFitTogether) {
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  std::uniform_int_distribution<std::int32_t> row(0, 499);
  std::uniform_real_distribution<float> strength(0.0f, 1.0f);
  std::vector<Coupling> couplings;
  for (int i = 0; i < 2000; ++i) {
    const Coupling c{row(rng), row(rng), strength(rng)};
    if (c.a != c.b) couplings.push_back(c);
  }
  constexpr std::size_t kMost = 20;
  const Numbers cluster = strong_clusters(500, couplings, kMost);
  std::map<std::int32_t, std::size_t> size;
  for (const std::int32_t c : cluster) ++size[c];
  for (const auto& [c, n] : size) EXPECT_LE(n, kMost) << c;
  for (const Coupling& c : couplings)
    if (cluster[c.a] != cluster[c.b]) {
      EXPECT_GT(size[cluster[c.a]] + size[cluster[c.b]], kMost);
    }
}

}  // namespace
}  // namespace brim::testing::strong_clusters_test
