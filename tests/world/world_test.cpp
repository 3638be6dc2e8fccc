#include "brim/world/world.h"

#include <gtest/gtest.h>

#include <random>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "support/heap.h"
#include "support/soft_worlds.h"

/// Laws of a world as such: state, determinism, cost. What bodies do in it is in scenes_test.cpp.
namespace brim::world_test {
namespace {

using testing::ball;
using testing::box;
using testing::ground;
using testing::options_at;
using testing::position;
using testing::run;
using testing::velocity;

constexpr unsigned kSeed = 101;

/// Boxes and balls of two sizes that fall onto the ground and each other. Heights and offsets are dyadic.
World pile(const Vec3& shift = Vec3::Zero(), const Vec3& ground_shift = Vec3::Zero()) {
  std::mt19937 rng(kSeed);
  std::uniform_int_distribution<int> jitter(-200, 200);
  World w(options_at(0.125));
  w.add(testing::obstacle("ground", make_half_space(), 0.5, ground_shift));
  int n = 0;
  for (int layer = 0; layer < 2; ++layer)
    for (int i = 0; i < 3; ++i, ++n) {
      testing::Start s;
      s.x = Vec3(1.0625 * (i % 2), 1.0625 * (i / 2), 0.5 + 1.125 * layer) +
            Vec3(jitter(rng), jitter(rng), std::abs(jitter(rng))) / 4096.0 + shift;
      s.v = Vec3(jitter(rng), jitter(rng), -std::abs(jitter(rng))) / 200.0;
      s.w = Vec3(jitter(rng), jitter(rng), jitter(rng)) / 200.0;
      if (n % 2)
        w.add(ball("ball" + std::to_string(n), s));
      else
        w.add(box("box" + std::to_string(n), s));
    }
  return w;
}

TEST(World, ASingleFallByHand) {
  World w(options_at(0.1));
  w.add(ball("ball", {Vec3(0, 0, 10)}));
  const StepReport r = w.step();
  const double dt = 1.0 / 60.0;
  EXPECT_NEAR(velocity(w, 0).z(), -9.81 * dt, 1e-13);
  EXPECT_NEAR(position(w, 0).z(), 10 - 0.5 * 9.81 * dt * dt, 1e-13);
  EXPECT_NEAR(r.time, dt, 1e-15);
  EXPECT_EQ(r.substeps, 1);
  EXPECT_TRUE(r.ok);
}

TEST(World, DistantBodiesCostNoVoxels) {
  World w(options_at(0.125));
  w.add(ground(0.5));
  for (int i = 0; i < 5; ++i) w.add(box("box" + std::to_string(i), {Vec3(3.0 * i, 0, 4.0 + i)}));
  for (int s = 0; s < 5; ++s) {
    const StepReport r = w.step();
    EXPECT_EQ(r.voxels, 0);
    EXPECT_EQ(r.tiles, 0);
    EXPECT_EQ(r.contacts, 0);
  }
}

TEST(World, OnlyTilesWithTwoPartsAreSampled) {
  World w = pile();
  for (int s = 0; s < 30; ++s) {
    const StepReport r = w.step();
    EXPECT_LE(r.voxels, r.tiles * kCubeNodes);
    EXPECT_GE(r.voxels, r.tiles);
    if (r.substeps > 1) continue;  // the report sums over sub-steps
    ASSERT_FALSE(w.active_tiles().empty());
  }
  // Each active tile holds nodes of a cube in which two parts were sampled: both have density within that cube's width
  // of it.
  run(w, 3.0);
  const State before = w.state();
  w.step();
  const std::vector<std::pair<TileKey, double>> active(w.active_tiles().begin(), w.active_tiles().end());
  w.set_state(before);
  for (const auto& [tile, h] : active) {
    int near = 0;
    for (int p = 0; p < w.part_count(); ++p) {
      std::vector<TileKey> present;
      const Aabb around = tile_box(tile, h).inflated(kCubeOwn * h);
      w.body(w.part(p).body).presence(0, h, 3 * h, around, present);
      near += std::any_of(present.begin(), present.end(),
                          [&](const TileKey& t) { return tile_box(t, h).inflated(h).overlaps(around); });
    }
    EXPECT_GE(near, 2);
  }
}

TEST(World, OneTwoOrFourThreadsGiveTheSameBitsAtEveryStep) {
  SCOPED_TRACE(kSeed);
  std::vector<std::uint64_t> one;
  for (const int threads : {1, 2, 4}) {
    const ThreadLimit limit(threads);
    World w = pile();
    for (int s = 0; s < 60; ++s) {
      w.step();
      if (threads == 1) one.push_back(w.hash());
      ASSERT_EQ(w.hash(), one[s]) << threads << " threads, step " << s;
    }
  }
  EXPECT_NE(one.front(), one.back());
}

TEST(World, ASnapshotThatContinuesEqualsOneStraightRunBitForBit) {
  World straight = pile();
  run(straight, 0.5);
  const State snapshot = straight.state();
  World resumed = pile();
  resumed.set_state(snapshot);
  EXPECT_EQ(resumed.hash(), straight.hash());
  for (int s = 0; s < 30; ++s) {
    straight.step();
    resumed.step();
    ASSERT_EQ(resumed.hash(), straight.hash()) << "step " << s;
  }
  // The same world rewound takes the same way again.
  const std::uint64_t end = straight.hash();
  straight.set_state(snapshot);
  for (int s = 0; s < 30; ++s) straight.step();
  EXPECT_EQ(straight.hash(), end);
}

TEST(World, MovingTheSceneByWholeVoxelsShiftsTheMotion) {
  SCOPED_TRACE(kSeed);
  double worst = 0.0;
  for (const Vec3& voxels : {Vec3(24, -48, 72), Vec3(8, 16, -8), Vec3(5, -7, 11)}) {
    const Vec3 shift = 0.125 * voxels, level(0, 0, shift.z());
    World here = pile(), there = pile(shift, level);
    for (int s = 0; s < 60; ++s) {
      here.step();
      there.step();
      for (int b = 1; b < here.body_count(); ++b)
        worst = std::max(worst, (position(there, b) - position(here, b) - shift).norm());
    }
  }
  // Sums in another order of tiles and orientations times positions round differently, 1e-16, and collisions make that
  // grow: 1e-11 after a second.
  EXPECT_LT(worst, 1e-9);
  RecordProperty("worst", std::to_string(worst));
}

TEST(World, ARestingSceneNeitherGrowsNorLeaksMemory) {
  const ThreadLimit one(1);  // other threads have arenas of their own
  if (!testing::heap_is_measurable()) GTEST_SKIP() << "this allocator does not say what is in use";
  World w(options_at(0.125));
  w.add(ground(0.5));
  w.add(box("box", {Vec3(0, 0, 0.5)}));
  w.add(ball("ball", {Vec3(2, 0, 0.5)}));
  for (int s = 0; s < 200; ++s) w.step();
  const std::size_t early = testing::bytes_in_use();
  for (int s = 0; s < 1000; ++s) w.step();
  const std::size_t late = testing::bytes_in_use();
  EXPECT_LT(late, early + 4000) << "a leak of one double a step would be 8 kB";
}

TEST(World, StateOfAnotherSizeIsRefused) {
  World w = pile();
  State s = w.state();
  s.v.pop_back();
  EXPECT_THROW(w.set_state(s), InputError);
}

TEST(World, AStateThatIsNoneIsRefused_AndTheOldOneKept) {
  World w = pile();
  const State before = w.state();
  const auto spoilt = [&](const auto& change) {
    State s = before;
    change(s);
    return s;
  };
  const std::size_t first = before.q.size() - 7;  // the last body's
  EXPECT_THROW(w.set_state(spoilt([&](State& s) { s.q[first] = std::nan(""); })), InputError);
  EXPECT_THROW(w.set_state(spoilt([&](State& s) { s.v.back() = INFINITY; })), InputError);
  EXPECT_THROW(w.set_state(spoilt([&](State& s) { std::fill_n(s.q.begin() + first + 3, 4, 0.0); })), InputError);
  EXPECT_EQ(w.state().q, before.q);
  EXPECT_EQ(w.state().v, before.v);
  EXPECT_THROW(w.add(nullptr), InputError);
}

TEST(World, WhatWasFoundOfOneStateIsNotToldOfAnother) {
  World w = pile();
  const State start = w.state();
  while (w.contacts().empty()) ASSERT_TRUE(w.step().ok);
  ASSERT_FALSE(w.active_tiles().empty());
  w.set_state(start);
  EXPECT_TRUE(w.contacts().empty());
  EXPECT_TRUE(w.active_tiles().empty());
}

TEST(World, NamesAreUniqueAndOptionsInRange) {
  World w(options_at(0.1));
  w.add(ball("a", {}));
  EXPECT_THROW(w.add(ball("a", {})), InputError);
  WorldOptions o;
  o.time_step = 0.0;
  EXPECT_THROW(World{o}, InputError);
  o = {};
  o.ramp_voxels = 7.0;
  EXPECT_THROW(World{o}, InputError);
}

TEST(World, AnEmptyWorldSteps) {
  World w;
  EXPECT_TRUE(w.step().ok);
  EXPECT_EQ(w.state().step, 1);
}

TEST(World, TooManyTilesAreRefusedBeforeTheyAreAllocated) {
  WorldOptions o = options_at(0.01);
  o.memory_limit = 1e6;
  World w(o);
  w.add(ground(0.5));
  w.add(testing::jelly("jelly", 1.0, Vec3::Zero()));  // solids are searched in cubes and need no blocks
  EXPECT_THROW(w.step(), InputError);
}

TEST(World, PartsMeetAtTheFinerOfTheirTwoSteps) {
  WorldOptions o = options_at(0.05);
  World w(o);
  RigidModel coarse;
  coarse.shape = make_box(Vec3::Constant(1.0));
  coarse.mass = 1000.0, coarse.inertia = 166.0 * Mat3::Identity();
  coarse.part.voxel_size = 0.2;
  auto body = std::make_unique<RigidBody>(coarse);
  body->set_name("coarse");
  w.add(std::move(body));
  w.add(ball("fine", {Vec3(0, 0, 0.75)}, 0.5, 0.25));
  w.step();
  ASSERT_FALSE(w.active_tiles().empty());
  for (const auto& [tile, h] : w.active_tiles()) EXPECT_EQ(h, 0.05);
}

}  // namespace
}  // namespace brim::world_test
