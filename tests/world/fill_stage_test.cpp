#include "brim/world/fill_stage.h"

#include <gtest/gtest.h>

#include <cmath>

#include "brim/core/parallel.h"
#include "support/particle_fluids.h"
#include "support/worlds.h"

namespace brim::fill_stage_test {
namespace {

using namespace testing::fluids;

std::unique_ptr<Body> fluid(std::vector<Vec3> x, double viscosity = 1.0, double spacing = kSpacing) {
  ParticleFluidOptions o = options(viscosity);
  o.spacing = spacing;
  o.material.friction = 0.0;
  auto b = std::make_unique<ParticleFluidBody>(std::move(x), o);
  b->set_name("fluid");
  return b;
}

/// Walls that stand on a floor around a square, with water in between.
World tank(double side, FluidLattice water) {
  WorldOptions o;
  o.time_step = 0.005;
  o.voxel_size = 0.025;
  World w(o);
  w.add(testing::obstacle("floor", make_half_space(), 0.0));
  w.add(testing::obstacle("west", make_box(Vec3(0.1, 0.8, 0.6)), 0.0, Vec3(-0.5 * side - 0.05, 0, 0.3)));
  w.add(testing::obstacle("east", make_box(Vec3(0.1, 0.8, 0.6)), 0.0, Vec3(0.5 * side + 0.05, 0, 0.3)));
  w.add(testing::obstacle("south", make_box(Vec3(0.8, 0.1, 0.6)), 0.0, Vec3(0, -0.5 * side - 0.05, 0.3)));
  w.add(testing::obstacle("north", make_box(Vec3(0.8, 0.1, 0.6)), 0.0, Vec3(0, 0.5 * side + 0.05, 0.3)));
  w.add(fluid(std::move(water.x), 1.0, water.spacing));
  return w;
}

World tank(double depth, double side = 0.4) {
  return tank(side, {block(Vec3(side, side, depth), 0.0, Vec3(-0.5 * side, -0.5 * side, 0)), kSpacing});
}

TEST(FillStage, WallsOnAFloorCarryNoneOfTheWeightAndTheHydrostaticForceAcross) {
  const double depth = 0.3;
  World w = tank(depth);
  testing::run(w, 1.0);
  Vec3 force[5];
  for (Vec3& f : force) f.setZero();
  double height = 0.0, error = 0.0;
  const int steps = 100;
  for (int i = 0; i < steps; ++i) {
    const StepReport r = w.step();
    ASSERT_TRUE(r.ok);
    error = std::max(error, r.momentum_error);
    for (const PairReport& p : r.pairs) force[p.part_a] -= p.force_on_a / steps;
    const auto q = w.q(5);
    for (std::size_t k = 2; k < q.size(); k += 3) height += 2.0 * q[k] * 3.0 / static_cast<double>(q.size()) / steps;
  }
  for (Vec3& f : force) f = -f;  // on the obstacle, which is a
  const double weight = 9.81 * w.body(5).mass();
  EXPECT_NEAR(-force[0].z(), weight, 0.01 * weight);
  for (int b = 1; b < 5; ++b) EXPECT_NEAR(force[b].z(), 0.0, 1e-3 * weight);
  EXPECT_NEAR(height, depth, 0.02 * depth);  // twice that of the centre of mass
  const double across = 0.5 * 1000.0 * 9.81 * 0.4 * height * height;
  for (int b = 1; b < 5; ++b) {
    const Vec3 out = Vec3((b == 2) - (b == 1), (b == 4) - (b == 3), 0.0);
    EXPECT_NEAR(force[b].dot(out), across, 0.03 * across) << b;
  }
  EXPECT_LT(error, 1e-12);
}

TEST(FillStage, WhatFluidAndSolidGiveEachOtherIsTheSame) {
  WorldOptions o;
  o.environment.gravity.setZero();
  o.time_step = 0.002;
  o.voxel_size = 0.025;
  o.cg_tolerance = 1e-10;
  World w(o);
  w.add(fluid(block(Vec3(0.3, 0.3, 0.2), 0.1, Vec3(-0.15, -0.15, -0.2))));
  testing::Start s;
  s.x = Vec3(0.03, -0.02, 0.13), s.v = Vec3(0.3, 0, -2.0), s.w = Vec3(1, 2, 3);
  w.add(testing::box("box", s, 0.0, 0.2, 600.0));
  const auto momentum = [&](Vec3& p, Vec3& l) {
    p.setZero(), l.setZero();
    for (int b = 0; b < 2; ++b) p += w.body(b).linear_momentum(w.v(b)), l += w.body(b).angular_momentum(w.v(b));
  };
  Vec3 p0, l0, p1, l1;
  momentum(p0, l0);
  const double mine = w.body(1).linear_momentum(w.v(1)).z();
  for (int i = 0; i < 50; ++i) {
    const StepReport r = w.step();
    ASSERT_TRUE(r.ok);
    EXPECT_LT(r.momentum_error, 1e-12);
    EXPECT_LT(r.angular_error, 1e-12);
  }
  momentum(p1, l1);
  const double given = std::abs(w.body(1).linear_momentum(w.v(1)).z() - mine);
  EXPECT_GT(given, 0.1 * std::abs(mine));
  EXPECT_LT((p1 - p0).norm(), 1e-7 * given);
}

TEST(FillStage, AFloatingBoxDisplacesItsWeight) {
  // Wide and low, so that it floats upright; 4 spacings wide, 3 high, two thirds of the density.
  const double side = 0.6;
  World w = tank(0.3, side);
  RigidModel m;
  const Vec3 size(0.2, 0.2, 0.15);
  m.shape = make_box(size);
  m.mass = 1000.0 * 2.0 / 3.0 * size.prod();
  m.inertia = m.mass / 12.0 *
              Vec3(size.y() * size.y() + size.z() * size.z(), size.x() * size.x() + size.z() * size.z(),
                   size.x() * size.x() + size.y() * size.y())
                  .asDiagonal()
                  .toDenseMatrix();
  m.position = Vec3(0, 0, 0.3);
  m.part.material.friction = 0.0;
  auto box = std::make_unique<RigidBody>(m);
  box->set_name("box");
  w.add(std::move(box));
  testing::run(w, 2.0);
  double lift = 0.0, bottom = 0.0;
  const int steps = 200;
  for (int i = 0; i < steps; ++i) {
    const StepReport r = w.step();
    ASSERT_TRUE(r.ok);
    for (const PairReport& p : r.pairs)
      if (p.part_b == 6) lift -= p.force_on_a.z() / steps;
    bottom += (testing::position(w, 6).z() - 0.5 * size.z()) / steps;
  }
  EXPECT_NEAR(lift, 9.81 * m.mass, 0.02 * 9.81 * m.mass);
  // The surface of a pool that keeps its volume: water and what lies in it, over the floor.
  const double surface = (w.body(5).mass() + m.mass) / 1000.0 / (side * side);
  EXPECT_NEAR(surface - bottom, 0.1, 0.1 * 0.1);
}

TEST(FillStage, APoolWhoseSidesAreNoWholeSpacingsStartsAtRest) {
  // Cubes of one spacing, nine in a row of 8.5, would start a quarter of a spacing from the walls.
  const double side = 8.5 * kSpacing, depth = 6.4 * kSpacing;
  const Vec3 lo(-0.5 * side, -0.5 * side, 0);
  World w = tank(side, lattice_in_box(lo, lo + Vec3(side, side, depth), kSpacing));
  EXPECT_NEAR(w.body(5).mass(), 1000.0 * side * side * depth, 1e-9);
  double fastest = 0.0, highest = 0.0;
  for (int i = 0; i < 60; ++i) {
    ASSERT_TRUE(w.step().ok);
    const auto q = w.q(5), v = w.v(5);
    for (std::size_t k = 0; k < v.size(); k += 3) {
      fastest = std::max(fastest, Vec3(v[k], v[k + 1], v[k + 2]).norm());
      highest = std::max(highest, q[k + 2]);
    }
  }
  // As of whole spacings, whose lattice gives way at some 0.2 m/s; 2.7 m/s from a quarter of a spacing.
  EXPECT_LT(fastest, 0.4);
  EXPECT_LT(highest, depth);
}

TEST(FillStage, AFilmBetweenPlatesIsShearedByItsViscosity) {
  // Newton's law: F = μ A v / H on both plates, from a linear profile on.
  const double side = 0.4, height = 0.15, speed = 0.1, viscosity = 5.0;
  WorldOptions o;
  o.environment.gravity.setZero();
  o.time_step = 0.002;
  o.voxel_size = 0.025;
  World w(o);
  w.add(testing::obstacle("floor", make_half_space(), 0.0));
  testing::Start s;
  s.x = Vec3(0, 0, height + 0.5 * side), s.v = Vec3(speed, 0, 0);
  w.add(testing::box("lid", s, 0.0, side, 1e4));
  ParticleFluidOptions f = options(viscosity);
  f.material.friction = 0.0;
  auto film =
      std::make_unique<ParticleFluidBody>(block(Vec3(side, side, height), 0.0, Vec3(-0.5 * side, -0.5 * side, 0)), f);
  film->set_name("film");
  w.add(std::move(film));
  State state = w.state();
  for (std::size_t i = 0; i + 2 < w.q(2).size(); i += 3)
    state.v[state.v.size() - w.v(2).size() + i] = speed * w.q(2)[i + 2] / height;
  w.set_state(state);
  const double expected = viscosity * side * side * speed / height;
  const StepReport r = w.step();
  ASSERT_TRUE(r.ok);
  int plates = 0;
  for (const PairReport& p : r.pairs) {
    const double along = p.part_a == 2 || p.part_b == 2 ? std::abs(p.force_on_a.x()) : 0.0;
    EXPECT_NEAR(along, expected, 0.05 * expected) << p.part_a << " " << p.part_b;
    ++plates;
  }
  EXPECT_EQ(plates, 2);
  EXPECT_LT(r.momentum_error, 1e-12);
}

TEST(FillStage, AWorldThatTakesAStateUpStepsLikeTheOneThatHadIt) {
  const auto make = [] {
    World w = tank(0.1);
    testing::Start s;
    s.x = Vec3(0, 0, 0.2), s.v = Vec3(0, 0, -2.0);
    w.add(testing::box("box", s, 0.0, 0.15, 600.0));
    return w;
  };
  World went_on = make(), taken_up = make();
  testing::run(went_on, 0.05);
  taken_up.set_state(went_on.state());
  for (int i = 0; i < 3; ++i) {
    went_on.step(), taken_up.step();
    ASSERT_EQ(went_on.hash(), taken_up.hash()) << i;
  }
}

TEST(FillStage, OneThreadAndThreeGiveTheSameBits) {
  std::uint64_t hash[2];
  for (int k = 0; k < 2; ++k) {
    const ThreadLimit limit(k == 0 ? 1 : 3);
    World w = tank(0.2);
    testing::Start s;
    s.x = Vec3(0, 0, 0.22);
    w.add(testing::ball("ball", s, 0.0, 0.07, 300.0));
    testing::run(w, 0.05);
    hash[k] = w.hash();
  }
  EXPECT_EQ(hash[0], hash[1]);
}

}  // namespace
}  // namespace brim::fill_stage_test
