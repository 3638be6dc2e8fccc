#include "brim/body/particles/loose_clusters.h"

#include <gtest/gtest.h>

#include <random>

namespace brim::testing::loose_clusters_test {
namespace {

constexpr unsigned kSeed = 11;

bool inside(const Aabb& box, const Vec3& p) {
  return ((p - box.lo).array() >= 0.0).all() && ((box.hi - p).array() >= 0.0).all();
}

/// Particles that lie and move anyhow, with six numbers of velocity each.
struct Scattered {
  std::vector<Vec3> x;
  std::vector<double> v;
  ParticleCells cells;

  Scattered() {
    std::mt19937 rng(kSeed);
    std::normal_distribution<double> normal;
    for (int i = 0; i < 200; ++i) x.emplace_back(normal(rng), normal(rng), normal(rng));
    for (int i = 0; i < 1200; ++i) v.push_back(normal(rng));
    cells.build(x, 0.5);
  }
  Vec3 velocity(std::int32_t i) const { return {v[6 * i], v[6 * i + 1], v[6 * i + 2]}; }
};

TEST(LooseClusters, EveryParticleIsHeldByItsCellAndAlone) {
  SCOPED_TRACE(kSeed);
  const Scattered s;
  std::vector<MotionCluster> coarse;
  measure_cells(s.cells, s.x, s.v, 0.01, coarse);
  ASSERT_EQ(coarse.size(), s.cells.cells());
  std::size_t held = 0;
  for (std::size_t c = 0; c < coarse.size(); ++c) {
    EXPECT_LE(coarse[c].box.extent().maxCoeff(), 0.5 + 0.02 + 1e-12);
    std::vector<MotionCluster> fine;
    measure_cell(s.cells, c, s.x, s.v, 0.01, fine);
    ASSERT_EQ(fine.size(), s.cells.of_cell(c).size());
    for (std::size_t k = 0; k < fine.size(); ++k, ++held) {
      const std::int32_t i = s.cells.of_cell(c)[k];
      EXPECT_TRUE(fine[k].box.center().isApprox(s.x[i], 1e-12));
      EXPECT_EQ(fine[k].velocity.lo, s.velocity(i));
      EXPECT_EQ(fine[k].velocity.hi, s.velocity(i));
      EXPECT_TRUE(inside(coarse[c].box, s.x[i]) && inside(coarse[c].velocity, s.velocity(i)));
    }
  }
  EXPECT_EQ(held, s.x.size());
}

}  // namespace
}  // namespace brim::testing::loose_clusters_test
