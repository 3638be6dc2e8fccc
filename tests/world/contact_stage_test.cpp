#include "brim/world/contact_stage.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

#include "brim/core/error.h"
#include "support/soft_worlds.h"
#include "support/worlds.h"

namespace brim::contact_stage_test {
namespace {

constexpr unsigned kSeed = 102;

/// Random boxes, balls and a plane: some apart, some overlapping.
World crowd(unsigned seed, int count) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> u(-1, 1);
  WorldOptions o = testing::options_at(0.125);
  o.max_substeps = 1;  // what overlaps this much is thrown, and would be cut again
  World w(o);
  w.add(testing::ground(0.5, Vec3(0.1, -0.2, 1).normalized()));
  for (int i = 0; i < count; ++i) {
    const double x = u(rng), y = u(rng), z = u(rng), a = u(rng), b = u(rng), c = u(rng);
    const testing::Start s{Vec3(2 * x, 2 * y, 1.2 + 1.5 * z), rotation_from_vector(2 * Vec3(a, b, c))};
    if (i % 2)
      w.add(testing::ball("ball" + std::to_string(i), s, 0.5, 0.3 + 0.2 * std::abs(x)));
    else
      w.add(testing::box("box" + std::to_string(i), s, 0.5, 0.6 + 0.3 * std::abs(y)));
  }
  return w;
}

TEST(ContactStage, WhatMeetsTooFarAwayForTheGridIsRefusedByName) {
  for (const double far : {1e9, 1e17, 1e300}) {
    World w(testing::options_at(0.1));
    w.add(testing::ground(0.5));
    w.add(testing::ball("near", {Vec3(0, 0, 5)}));
    w.add(testing::ball("far", {Vec3(far, 0, 0.4)}));
    try {
      w.step();
      FAIL() << far;
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find("'far'"), std::string::npos) << e.what();
    }
  }
  // Near enough, each of them, but with all that lies between them on one rope.
  World apart(testing::options_at(0.1));
  apart.add(testing::rope("rope", Vec3::Zero(), Vec3(3e4, 3e4, 3e4)));
  apart.add(testing::ball("one", {Vec3(0, 0, 0)}));
  apart.add(testing::ball("other", {Vec3(3e4, 3e4, 3e4)}));
  EXPECT_THROW(apart.step(), InputError);
  // Solids are looked at pair by pair: how far pairs are from each other does not matter.
  World solids(testing::options_at(0.1));
  solids.add(testing::ground(0.5));
  solids.add(testing::ball("one", {Vec3(0, 0, 0.49)}));
  solids.add(testing::ball("other", {Vec3(3e4, 3e4, 0.49)}));
  EXPECT_GT(solids.step().contacts, 0);

  World w(testing::options_at(0.1));
  w.add(testing::ground(0.5));
  w.add(testing::ball("ball", {Vec3(1e6, 0, 0.49)}));
  EXPECT_GT(w.step().contacts, 0) << "a thousand kilometres are near enough";
}

/// Steps a world once, by one sub-step, and compares the contacts it found with all nodes of a box.
/// @return how many pairs overlap
std::size_t expect_all_found(World& w, double h, const Aabb& box) {
  // All nodes of a box around everything, every pair of parts.
  std::vector<TileKey> tiles;
  const TileRange range = tiles_meeting(box, h);
  for (int z = range.lo.z; z <= range.hi.z; ++z)
    for (int y = range.lo.y; y <= range.hi.y; ++y)
      for (int x = range.lo.x; x <= range.hi.x; ++x) tiles.push_back({x, y, z});
  const int parts = w.part_count();
  std::vector<std::vector<DensityBlock>> density(parts, std::vector<DensityBlock>(tiles.size()));
  for (int p = 0; p < parts; ++p) w.density(p, h, tiles, density[p]);
  // Contact is sampled in single precision: nodes that overlap by less than its rounding may be found or not.
  constexpr double kRounding = 1e-6;
  std::map<std::pair<int, int>, std::int64_t> sure, possible;
  for (int a = 0; a < parts; ++a)
    for (int b = a + 1; b < parts; ++b)
      for (std::size_t t = 0; t < tiles.size(); ++t)
        for (int k = 1; k <= kTileSize; ++k)
          for (int j = 1; j <= kTileSize; ++j)
            for (int i = 1; i <= kTileSize; ++i) {
              const int node = block_index(i, j, k);
              const auto full = [&](int p) {
                const double* r = density[p][t].rho + node;
                return r[0] >= 1 && r[1] >= 1 && r[-1] >= 1 && r[10] >= 1 && r[-10] >= 1 && r[100] >= 1 && r[-100] >= 1;
              };
              const double sum = density[a][t].rho[node] + density[b][t].rho[node];
              if (full(a) && full(b)) continue;
              if (sum > 1.0 + kRounding) ++sure[{a, b}];
              if (sum > 1.0 - kRounding) ++possible[{a, b}];
            }
  // One sub-step: its contacts are those of the state before it.
  const StepReport r = w.step();
  EXPECT_EQ(r.substeps, 1);
  std::map<std::pair<int, int>, std::int64_t> found;
  for (const ContactSample& c : w.contacts())
    if (c.overlap > 0.0f) ++found[{c.part_a, c.part_b}];
  for (const auto& [pair, count] : sure) EXPECT_GE(found[pair], count) << pair.first << " " << pair.second;
  for (const auto& [pair, count] : found) EXPECT_LE(count, possible[pair]) << pair.first << " " << pair.second;
  return sure.size();
}

TEST(ContactStage, FindsEveryOverlapThatASearchOfAllTilesFinds) {
  for (unsigned seed = kSeed; seed < kSeed + 4; ++seed) {
    SCOPED_TRACE(seed);
    World w = crowd(seed, 24);
    EXPECT_GT(expect_all_found(w, 0.125, {Vec3(-4, -4, -3), Vec3(4, 4, 5)}), 4u);
  }
}

TEST(ContactStage, FindsEveryOverlapOfBodiesThatDeform) {
  // Of every kind that says in which octants it is, against each other and against solids.
  const double h = 0.1;
  WorldOptions o = testing::options_at(h);
  o.max_substeps = 1;
  World w(o);
  w.add(testing::ground(0.5, Vec3(0.1, -0.2, 1).normalized()));
  w.add(testing::jelly("jelly", 0.5, Vec3(-0.23, -0.24, -0.02)));
  w.add(testing::jelly("other", 0.5, Vec3(0.21, -0.1, 0.3)));
  w.add(testing::sheet("sheet", 0.8, Vec3(0.01, 0.02, 0.5)));
  w.add(testing::springs("springs", 0.4, Vec3(-0.4, 0.1, 0.42)));
  w.add(testing::rope("rope", Vec3(-0.3, -0.5, 0.1), Vec3(0.3, 0.6, 0.45)));
  w.add(testing::ball("ball", {Vec3(0.5, 0.4, 0.4)}, 0.5, 0.3));
  EXPECT_GT(expect_all_found(w, h, {Vec3(-1.5, -1.5, -0.5), Vec3(1.5, 1.5, 1.5)}), 6u);
}

TEST(ContactStage, ABodyInAnEmptyPlaceIsNotRasterized) {
  // Two touch, a third stands alone: only nodes of the two are sampled.
  World w(testing::options_at(0.125));
  w.add(testing::ball("a", {Vec3(0, 0, 0)}));
  w.add(testing::ball("b", {Vec3(0.95, 0, 0)}));
  w.add(testing::ball("alone", {Vec3(0, 9, 0)}));
  const StepReport r = w.step();
  EXPECT_GE(r.tiles, 2);
  EXPECT_GT(r.voxels, r.contacts);
  EXPECT_FALSE(w.active_tiles().empty());
  for (const auto& [tile, h] : w.active_tiles()) EXPECT_LT(tile_box(tile, h).lo.y(), 2.0);
}

}  // namespace
}  // namespace brim::contact_stage_test
