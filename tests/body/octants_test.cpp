#include <gtest/gtest.h>

#include <random>

#include "support/carried.h"
#include "support/soft_worlds.h"

namespace brim::octants_test {
namespace {

/// Calls f(node) for the nodes of a block that stencils at an octant's own nodes read.
template <class F>
void for_octant(int octant, const F& f) {
  constexpr int kHalf = kTileSize / 2;
  for (int k = 0; k < kHalf + 2 * kHalo; ++k)
    for (int j = 0; j < kHalf + 2 * kHalo; ++j)
      for (int i = 0; i < kHalf + 2 * kHalo; ++i)
        f(block_index(i + kHalf * (octant & 1), j + kHalf * (octant >> 1 & 1), k + kHalf * (octant >> 2)));
}

TEST(Octants, BodiesOfAllKindsFillThoseThatAreWantedAsTheyFillWholeTiles) {
  constexpr unsigned kSeed = 11;
  SCOPED_TRACE(kSeed);
  std::mt19937 random(kSeed);
  std::uniform_int_distribution<int> byte(1, 255);
  std::vector<std::unique_ptr<Body>> bodies;
  bodies.push_back(testing::ground(0.5, Vec3(0.2, 0.1, 1.0).normalized()));
  bodies.push_back(testing::box("box", {Vec3(0.02, 0.01, 0.1)}));
  bodies.push_back(testing::jelly("jelly", 0.5, Vec3(-0.23, -0.24, -0.22)));
  bodies.push_back(testing::sheet("sheet", 0.8, Vec3(0.01, 0.02, 0.03)));
  bodies.push_back(testing::springs("springs", 0.4, Vec3(-0.2, -0.2, 0.0)));
  bodies.push_back(testing::rope("rope", Vec3(-0.1, -0.5, 0.1), Vec3(0.1, 0.5, 0.15)));
  bodies.push_back(testing::blob("blob", 5, 0.1, Vec3(-0.21, -0.22, -0.23)));
  bodies.push_back(testing::meshless(Vec3::Constant(0.5), 0.1, 0.05, testing::soft()));
  for (const auto& body : bodies) {
    SCOPED_TRACE(body->kind());
    std::vector<double> q(body->q_size()), v(body->v_size());
    body->initial_state(q, v);
    body->update(0.0, q, v);
    const double h = 0.05, w = 3 * h;
    std::vector<TileKey> tiles;
    const Aabb near{Vec3::Constant(-0.8), Vec3::Constant(0.8)};
    body->presence(0, h, w, near, tiles);
    ASSERT_FALSE(tiles.empty());
    std::vector<DensityBlock> whole(tiles.size()), some(tiles.size());
    body->rasterize(0, h, w, tiles, whole);
    for (DensityBlock& b : some) {
      b.octants = static_cast<Octants>(byte(random) & byte(random));
      std::fill(std::begin(b.rho), std::end(b.rho), 0.7);  // of an earlier step
    }
    body->rasterize(0, h, w, tiles, some);
    std::size_t filled = 0;
    for (std::size_t t = 0; t < tiles.size(); ++t)
      for (int o = 0; o < 8; ++o)
        if (some[t].octants >> o & 1)
          for_octant(o, [&](int n) {
            ASSERT_EQ(some[t].rho[n], whole[t].rho[n]) << "tile " << t << " node " << n;
            filled += whole[t].rho[n] > 0.0;
          });
    EXPECT_GT(filled, 100u);
  }
}

}  // namespace
}  // namespace brim::octants_test
