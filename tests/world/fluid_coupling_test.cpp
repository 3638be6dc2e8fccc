#include "brim/world/fluid_coupling.h"

#include <gtest/gtest.h>

#include <numbers>

#include "brim/body/cloth/cloth_body.h"
#include "brim/body/fem/fem_body.h"
#include "brim/body/grid_fluid/grid_fluid_body.h"
#include "brim/body/obstacle/obstacle_body.h"
#include "brim/body/walled.h"
#include "brim/mesh/primitives.h"
#include "support/solids.h"
#include "support/worlds.h"

namespace brim::fluid_coupling_test {
namespace {

constexpr double kCell = 0.0625;

std::unique_ptr<GridFluidBody> water(const std::function<double(const Vec3&)>& distance, double friction = 0.0) {
  GridFluidModel m;
  m.grid = {Vec3::Zero(), kCell, {16, 16, 16}};
  m.distance = distance;
  m.material.friction = friction;
  auto b = std::make_unique<GridFluidBody>(std::move(m));
  b->set_name("water");
  return b;
}

std::unique_ptr<GridFluidBody> pool(double level, double friction = 0.0) {
  return water([level](const Vec3& x) { return x.z() - level; }, friction);
}

WorldOptions options(const Vec3& gravity = Vec3(0.0, 0.0, -9.81)) {
  WorldOptions o = testing::options_at(kCell);
  o.time_step = 0.01;
  o.environment.gravity = gravity;
  return o;
}

const GridFluidBody& fluid_of(const World& w) { return dynamic_cast<const GridFluidBody&>(w.body(0)); }

TEST(FluidCoupling, LiftIsTheWeightOfWhatIsDisplacedWhereverASolidLiesInItsCells) {
  const double side = 0.25, radius = 0.14;  // 4 and 4.5 cells
  for (const double place : {0.0, 0.013, 0.031, 0.047}) {
    const Vec3 at(0.5 + place, 0.5 - 0.5 * place, 0.36 + 0.3 * place);
    for (const bool cube : {true, false}) {
      World w(options());
      w.add(pool(0.75));
      w.add(testing::obstacle("solid", cube ? make_box(Vec3::Constant(side)) : make_sphere(radius), 0.0, at));
      double lift = 0.0, energy = 0.0;
      for (int s = 0; s < 30; ++s) {
        const StepReport r = w.step();
        ASSERT_TRUE(r.ok);
        ASSERT_EQ(r.pairs.size(), 1u);
        EXPECT_LT(r.cg_iterations, 20) << "what rounding leaves is solved for";
        lift = -r.pairs[0].force_on_a.z(), energy = r.kinetic_energy;
      }
      const double volume = cube ? side * side * side : 4.0 / 3.0 * std::numbers::pi * radius * radius * radius;
      EXPECT_NEAR(lift, 9810.0 * volume, 0.03 * 9810.0 * volume) << place << (cube ? " cube" : " ball");
      // The water is still: what is left of it is the level, which rises by what was pushed out.
      EXPECT_LT(energy, 1e-2 * 9810.0 * volume * kCell);
    }
  }
}

TEST(FluidCoupling, NoWetCellGainsOrLosesWhatSolidsMove) {
  // The volume of water stays, and its level rises by what sinks into it.
  World w(options());
  w.add(pool(0.4));
  testing::Start start;
  start.x = Vec3(0.5, 0.5, 0.65);
  w.add(testing::ball("ball", start, 0.0, 0.2, 4000.0));
  w.add(testing::ground(0.0));
  const double ball = 4.0 / 3.0 * std::numbers::pi * 0.008;
  double level = 0.0;  // along the sides of the box, of the last second: waves run to and fro
  int counted = 0;
  for (int s = 0; s < 200; ++s) {
    ASSERT_TRUE(w.step().ok);
    EXPECT_NEAR(fluid_of(w).volume(), 0.4, 0.02 * 0.4);
    const auto phi = fluid_of(w).level_set();
    for (int i = 0; i < 16 && s >= 100; ++i)
      for (int k = 0; k + 1 < 16; ++k)
        for (const int j : {0, 15}) {
          const double lo = phi[fluid_of(w).grid().cell(i, j, k)], hi = phi[fluid_of(w).grid().cell(i, j, k + 1)];
          if (lo < 0.0 && hi >= 0.0) level += kCell * (k + 0.5 + lo / (lo - hi)), ++counted;
        }
  }
  EXPECT_LT(testing::position(w, 1).z(), 0.3);
  EXPECT_NEAR(level / counted, 0.4 + ball, 0.1 * kCell);
}

TEST(FluidCoupling, WhatOneTakesTheOtherGives) {
  // A ball flies into a drop that hangs in the air: no wall is near, and nothing else acts.
  World w(options(Vec3::Zero()));
  w.add(water([](const Vec3& x) { return (x - Vec3(0.5, 0.5, 0.55)).norm() - 0.25; }));
  testing::Start start;
  start.x = Vec3(0.5, 0.47, 0.2);
  start.v = Vec3(0.0, 0.0, 1.0);
  w.add(testing::ball("ball", start, 0.0, 0.1, 800.0));
  w.step();
  const auto momentum = [&] { return Vec3(w.body(0).linear_momentum(w.v(0)) + w.body(1).linear_momentum(w.v(1))); };
  const Vec3 before = momentum();
  for (int s = 0; s < 25; ++s) ASSERT_TRUE(w.step().ok);
  EXPECT_LT((momentum() - before).norm(), 1e-11 * before.norm());
  EXPECT_LT(w.body(1).linear_momentum(w.v(1)).norm(), 0.8 * before.norm());
}

TEST(FluidCoupling, ASolidOfItsBoxThatItDoesNotTouchLeavesItsPressure) {
  World w(options());
  w.add(pool(0.4));
  w.add(testing::obstacle("ball", make_sphere(0.14), 0.0, Vec3(0.5, 0.5, 0.75)));
  for (int s = 0; s < 20; ++s) ASSERT_TRUE(w.step().ok);
  EXPECT_LT(w.body(0).kinetic_energy(w.v(0)), 1e-12);
  EXPECT_NEAR(fluid_of(w).pressure(fluid_of(w).grid().cell(8, 8, 0)), 9810.0 * (0.4 - 0.5 * kCell), 1.0);
}

TEST(FluidCoupling, WhatLeavesTheBoxIsNotHeldByItsSides) {
  // A ball flies through the closed lid into a drop: nothing but the drop acts on it.
  World w(options(Vec3::Zero()));
  w.add(water([](const Vec3& x) { return (x - Vec3(0.5, 0.5, 0.75)).norm() - 0.22; }));
  testing::Start start;
  start.x = Vec3(0.53, 0.5, 1.14);
  start.v = Vec3(0.0, 0.0, -1.0);
  w.add(testing::ball("ball", start, 0.0, 0.16, 500.0));
  const auto momentum = [&] { return Vec3(w.body(0).linear_momentum(w.v(0)) + w.body(1).linear_momentum(w.v(1))); };
  const auto energy = [&] { return w.body(0).kinetic_energy(w.v(0)) + w.body(1).kinetic_energy(w.v(1)); };
  const double before = energy();
  for (int s = 0; s < 12; ++s) {
    ASSERT_TRUE(w.step().ok);
    EXPECT_LT(energy(), before * (1.0 + 1e-9)) << s;
    Vec3 walls = dynamic_cast<const Walled&>(w.body(0)).wall_impulse();
    EXPECT_LT((momentum() + walls).z(), 0.0) << s;
  }
  EXPECT_LT(w.v(1)[2], -0.5);
}

TEST(FluidCoupling, ADropThatMeetsASolidGainsNoEnergyAndLosesNoMomentum) {
  for (const bool free : {false, true}) {
    World w(options(Vec3::Zero()));
    w.add(std::make_unique<GridFluidBody>([] {
      GridFluidModel m;
      m.grid = {Vec3::Zero(), kCell, {16, 16, 16}};
      m.distance = [](const Vec3& x) { return (x - Vec3(0.5, 0.5, 0.6)).norm() - 0.22; };
      m.velocity = [](const Vec3&) { return Vec3(0.0, 0.0, -1.0); };
      m.material.friction = 0.0;
      return m;
    }()));
    testing::Start start;
    start.x = Vec3(0.53, 0.47, 0.2);
    if (free)
      w.add(testing::ball("ball", start, 0.0, 0.16, 500.0));
    else
      w.add(testing::obstacle("ball", make_sphere(0.16), 0.0, start.x));
    const double before = w.body(0).kinetic_energy(w.v(0));
    Vec3 told = w.body(0).linear_momentum(w.v(0));
    for (int s = 0; s < 30; ++s) {
      const StepReport r = w.step();
      ASSERT_TRUE(r.ok);
      EXPECT_LT(r.kinetic_energy, before * (1.0 + 1e-9)) << s;
      // Of fluid and pair: what contact reports is what the drop has lost.
      for (const PairReport& p : r.pairs) told += 0.01 * p.force_on_a;
      told += dynamic_cast<const Walled&>(w.body(0)).wall_impulse();
      EXPECT_LT((w.body(0).linear_momentum(w.v(0)) - told).norm(), 1e-10 * before) << s;
    }
  }
}

TEST(FluidCoupling, ALightBallIsHeldBackByTheWaterThatItDrags) {
  // Lamb, Hydrodynamics, § 92: a ball drags half of what it displaces.
  World w(options());
  w.add(water([](const Vec3& x) { return x.z() - 0.9; }));
  testing::Start start;
  start.x = Vec3(0.5, 0.5, 0.45);
  w.add(testing::ball("ball", start, 0.0, 0.14, 100.0));
  double v = 0.0;
  for (int s = 0; s < 3; ++s) w.step(), v = w.v(1)[2];
  const double ideal = 9.81 * 900.0 / (100.0 + 500.0);
  EXPECT_NEAR(v / 0.03, ideal, 0.2 * ideal);
}

TEST(FluidCoupling, AnObstacleThatIsMovedIsSeenWhereItIs) {
  const double radius = 0.14;
  World w(options());
  w.add(pool(0.75));
  w.add(testing::obstacle("ball", make_sphere(radius), 0.0, Vec3(0.5, 0.5, 0.36)));
  const auto center = [&] {
    for (int s = 0; s < 40; ++s) EXPECT_TRUE(w.step().ok);
    const StepReport r = w.step();
    EXPECT_EQ(r.pairs.size(), 1u);
    const double weight = 9810.0 * 4.0 / 3.0 * std::numbers::pi * radius * radius * radius;
    EXPECT_NEAR(-r.pairs.at(0).force_on_a.z(), weight, 0.05 * weight);
    return r.pairs.at(0).center;
  };
  const Vec3 before = center();
  w.move(1, {Mat3::Identity(), Vec3(0.13, 0.0, 0.0)});
  EXPECT_NEAR(center().x() - before.x(), 0.13, 0.02);
}

TEST(FluidCoupling, APistonThatLeavesASideOfTheBoxLeavesAirBehindIt) {
  // Water behind it could only follow through the sliver that opens, at any speed.
  World w(options());
  w.add(water([](const Vec3& x) { return std::max(0.17 - x.x(), x.z() - 0.35); }));
  ObstacleModel m;
  m.shape = make_box(Vec3(0.19, 1.5, 1.5));
  m.keys = {{0.0, Vec3(0.075, 0.5, 0.5), Quat::Identity()}, {1.0, Vec3(0.575, 0.5, 0.5), Quat::Identity()}};
  w.add(std::make_unique<ObstacleBody>(m));
  for (int s = 0; s < 30; ++s) {
    const StepReport r = w.step();
    ASSERT_TRUE(r.ok) << s;
    EXPECT_LT(r.max_speed, 8.0) << s;
  }
  EXPECT_GT(fluid_of(w).distance(Vec3(0.03, 0.5, 0.2)), 0.0) << "dry behind it";
}

TEST(FluidCoupling, ThinWallsAndStickyFluidsMeetByContact) {
  PartInfo thick, sheet, other, small, plank, rod;
  small.thickness = small.width = 0.3 * kCell;
  plank.thickness = 0.6 * kCell, plank.width = 1.4 * kCell;
  rod.thickness = 0.3 * kCell, rod.lines = true;
  thick.thickness = 2.0 * kCell;
  sheet.thickness = 0.5 * kCell;
  other.thickness = 2.0 * kCell, other.conforming = true;
  const auto slips = pool(0.5), sticks = pool(0.5, 0.3);
  EXPECT_TRUE(slips->flows_around(thick));
  EXPECT_FALSE(slips->flows_around(sheet));
  EXPECT_FALSE(slips->flows_around(other));
  for (const PartInfo& no_wall : {small, plank, rod}) EXPECT_TRUE(slips->flows_around(no_wall));
  EXPECT_FALSE(sticks->flows_around(thick));
}

TEST(FluidCoupling, ASoftSolidFloats) {
  FemOptions o;
  o.density = 500.0;
  o.young = 1e5;
  TetMesh mesh = testing::block(3, 3, 2, 0.125);
  for (Vec3& x : mesh.vertices) x += Vec3(0.31, 0.32, 0.4);
  World w(options());
  w.add(pool(0.5));
  auto soft = std::make_unique<FemBody>(std::move(mesh), o);
  soft->set_name("soft");
  w.add(std::move(soft));
  double mean = 0.0;
  for (int s = 0; s < 200; ++s) {
    ASSERT_TRUE(w.step().ok);
    for (std::size_t i = 2; i < w.q(1).size() && s >= 50; i += 3)
      mean += 3.0 * w.q(1)[i] / static_cast<double>(w.q(1).size()) / 150.0;
  }
  // Half of its 0.25 m is under water, whose level rises by half its volume.
  EXPECT_NEAR(mean, 0.5 + 0.5 * 0.375 * 0.375 * 0.25, 0.1 * 0.25);
}

TEST(FluidCoupling, WhatWaterHoldsMovesByTheVelocityThatItIsLeftWith) {
  // By the mean of those before and after, as in free flight, what bobs would swing ever higher.
  World w(options());
  w.add(pool(0.6));
  testing::Start start;
  start.x = Vec3(0.5, 0.5, 0.4);
  w.add(testing::ball("ball", start, 0.0, 0.15, 500.0));
  for (int s = 0; s < 5; ++s) {
    const double before = w.q(1)[2];
    ASSERT_TRUE(w.step().ok);
    EXPECT_NEAR(w.q(1)[2] - before, 0.01 * w.v(1)[2], 1e-12);
  }
}

TEST(FluidCoupling, WhatYieldsToWaterAloneIsSolvedForExactly) {
  // A light sheet under water: without its factor, 40 iterations a step and more.
  for (const bool held : {false, true}) {
    World w(options());
    w.add(pool(0.6));
    TriMesh mesh = shapes::grid(10, 10, 0.6, 0.6);
    for (Vec3& x : mesh.vertices) x += Vec3(0.5, 0.5, 0.3 + 0.1 * x.x());
    ClothOptions o;
    o.membrane.young = 2000, o.bending = 1e-2, o.areal_density = 1.0, o.thickness = 0.12, o.stiffness_damping = 0.005;
    if (held) o.fixed = {0, 10};
    auto sheet = std::make_unique<ClothBody>(mesh, o);
    sheet->set_name("sheet");
    w.add(std::move(sheet));
    for (int s = 0; s < 8; ++s) {
      const StepReport r = w.step();
      ASSERT_TRUE(r.ok);
      EXPECT_LE(r.cg_iterations, 6);
      ASSERT_EQ(r.pairs.size(), 1u);
    }
  }
}

}  // namespace
}  // namespace brim::fluid_coupling_test
