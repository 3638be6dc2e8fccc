#include <gtest/gtest.h>

#include <random>

#include "support/worlds.h"

/// What rigid bodies do on the ground, on inclines, in stacks and against walls.
namespace brim::scenes_test {
namespace {

using testing::ball;
using testing::box;
using testing::ground;
using testing::liveliness;
using testing::obstacle;
using testing::options_at;
using testing::position;
using testing::run;
using testing::spin;
using testing::velocity;

constexpr double kGravity = 9.81, kStep = 1.0 / 60.0;

Quat yaw(double angle) { return rotation_from_vector(Vec3(0, 0, angle)); }

TEST(Scene, ABoxRestsOnTheGroundWithoutDrift) {
  World w(options_at(0.125));
  w.add(ground(0.5));
  w.add(box("box", {Vec3(0.013, 0.021, 0.5), yaw(0.1)}));
  const double worst = run(w, 2.0);
  const Vec3 x = position(w, 1);
  run(w, 3.0);
  EXPECT_LT(worst, 0.05);  // voxels
  EXPECT_LT(liveliness(w), 1e-3);
  EXPECT_LT((position(w, 1) - x).norm(), 1e-3);
  EXPECT_NEAR(position(w, 1).z(), 0.5, 0.05 * 0.125);
}

TEST(Scene, ContactForceOfABoxAtRestIsItsWeight) {
  World w(options_at(0.125));
  w.add(ground(0.5));
  w.add(box("box", {Vec3(0, 0, 0.5), yaw(0.3)}));
  run(w, 2.0);
  const StepReport r = w.step();
  ASSERT_EQ(r.pairs.size(), 1u);
  EXPECT_LT((r.pairs[0].force_on_a + Vec3(0, 0, 1000 * kGravity)).norm(), 0.01 * 1000 * kGravity);
  EXPECT_LT(r.pairs[0].center.head<2>().norm(), 0.01);
}

TEST(Scene, ABoxPushedUpwardsIsLetGo) {
  World w(options_at(0.125));
  w.add(ground(0.5));
  w.add(box("box", {Vec3(0, 0, 0.5), yaw(0.1)}));
  run(w, 2.0);
  State s = w.state();
  s.v[6 + 2] = 1.0;
  w.set_state(s);
  for (int i = 1; i <= 6; ++i) {
    w.step();
    EXPECT_GE(velocity(w, 1).z() + kGravity * i * kStep, 0.98) << "step " << i;
    EXPECT_LE(velocity(w, 1).z() + kGravity * i * kStep, 1.02) << "contact gives no speed either, step " << i;
  }
}

/// A box on a plane of 20 degrees. @return acceleration over what Coulomb gives (or speed at the end when it sticks)
struct Slide {
  double acceleration, ideal, end_speed, drift;
};
Slide slide(double mu, double seconds, double turn = 0.0) {
  const double angle = 20.0 * std::numbers::pi / 180.0;
  const Vec3 n(std::sin(angle), 0, std::cos(angle)), down(std::cos(angle), 0, -std::sin(angle));
  World w(options_at(0.125));
  w.add(ground(mu, n));
  w.add(box("box", {0.5 * n, Quat::FromTwoVectors(Vec3(0, 0, 1), n) * yaw(turn)}, mu));
  const int steps = static_cast<int>(seconds / kStep + 0.5), first = steps / 4;
  double early = 0.0;
  const Vec3 x0 = position(w, 1);
  for (int s = 0; s < steps; ++s) {
    w.step();
    if (s == first) early = velocity(w, 1).dot(down);
  }
  const double v = velocity(w, 1).dot(down);
  return {(v - early) / ((steps - 1 - first) * kStep), kGravity * std::max(0.0, std::sin(angle) - mu * std::cos(angle)),
          v, (position(w, 1) - x0).dot(down)};
}

TEST(Scene, ABoxSlidesAsCoulombSays) {
  const Slide smooth = slide(0.0, 2.0), rough = slide(0.2, 2.0), turned = slide(0.2, 2.0, 0.4);
  RecordProperty("frictionless", std::to_string(smooth.acceleration / smooth.ideal));
  RecordProperty("mu_0.2", std::to_string(rough.acceleration / rough.ideal));
  RecordProperty("mu_0.2_turned", std::to_string(turned.acceleration / turned.ideal));
  EXPECT_NEAR(smooth.acceleration / smooth.ideal, 1.0, 0.01);
  EXPECT_NEAR(rough.acceleration / rough.ideal, 1.0, 0.05);
  EXPECT_NEAR(turned.acceleration / turned.ideal, 1.0, 0.05);
}

TEST(Scene, ABoxSlidesBelowTheAngleOfFrictionAndSticksAboveIt) {
  // tan 20° = 0.364
  const Slide slides = slide(0.35, 3.0), sticks = slide(0.38, 3.0);
  RecordProperty("creep", std::to_string(sticks.end_speed));
  EXPECT_GT(slides.drift, 0.05);
  EXPECT_GT(slides.end_speed, 0.1);
  EXPECT_LT(std::abs(sticks.end_speed), 1e-3);
}

TEST(Scene, ARollingBallKeepsItsSpeedWhicheverBodyComesFirst) {
  for (const double azimuth : {0.0, 0.6})
    for (const bool ground_first : {true, false}) {
      const Vec3 d(std::cos(azimuth), std::sin(azimuth), 0);
      const double v = 2.1;
      World w(options_at(0.125));
      if (ground_first) w.add(ground(0.5));
      const int b =
          w.add(ball("ball", {Vec3(0.03, 0.02, 0.5), Quat::Identity(), v * d, Vec3(0, 0, 1).cross(d) * v / 0.5}));
      if (!ground_first) w.add(ground(0.5));
      run(w, 2.2);
      RecordProperty("kept_" + std::to_string(azimuth) + (ground_first ? "_second" : "_first"),
                     std::to_string(velocity(w, b).dot(d) / v));
      EXPECT_GE(velocity(w, b).dot(d), 0.95 * v);
      EXPECT_LE(velocity(w, b).norm(), 1.01 * v);
      EXPECT_NEAR(spin(w, b).norm() * 0.5, velocity(w, b).norm(), 0.05 * v) << "it still rolls";
    }
}

TEST(Scene, ABallRollsOnAMovingBeltAsOnTheGround) {
  // The same scene seen from a frame that travels along: only relative motion counts.
  const double v = 2.1, belt = -1.5;
  World w(options_at(0.125));
  ObstacleModel m;
  m.shape = make_half_space();
  m.part.material.friction = 0.5;
  m.keys = {{0.0, Vec3::Zero(), Quat::Identity()}, {10.0, Vec3(10 * belt, 0, 0), Quat::Identity()}};
  auto b = std::make_unique<ObstacleBody>(m);
  b->set_name("belt");
  w.add(std::move(b));
  w.add(ball("ball", {Vec3(0.03, 0.02, 0.5), Quat::Identity(), Vec3(v + belt, 0, 0), Vec3(0, v / 0.5, 0)}));
  run(w, 2.2);
  RecordProperty("kept", std::to_string((velocity(w, 1).x() - belt) / v));
  EXPECT_GE(velocity(w, 1).x() - belt, 0.95 * v);
  EXPECT_LE(velocity(w, 1).x() - belt, 1.01 * v);
}

TEST(Scene, ABallThatLandsHardlyOverlaps) {
  // Nodes that will touch within the step act in it.
  double worst = 0.0;
  for (int i = 0; i < 8; ++i) {
    World w(options_at(0.125));
    w.add(ground(0.5));
    w.add(ball("ball", {Vec3(0.01 * i, 0, 0.8 + 0.013 * i)}));
    worst = std::max(worst, run(w, 1.0));
    EXPECT_NEAR(position(w, 1).z(), 0.5, 0.1 * 0.125);
  }
  RecordProperty("worst_overlap", std::to_string(worst));
  EXPECT_LT(worst, 0.27);  // voxels; measured 0.24, and 0.31 when only nodes in overlap act
}

TEST(Scene, AStackOfTenBoxesStands) {
  for (const int seed : {1, 2, 3}) {
    SCOPED_TRACE(seed);
    std::mt19937 rng(seed);
    std::uniform_real_distribution<double> u(-1, 1);
    World w(options_at(0.125));
    w.add(ground(0.5));
    for (int i = 0; i < 10; ++i) {
      const double x = u(rng), y = u(rng), turn = u(rng);
      w.add(box("box" + std::to_string(i), {Vec3(0.05 * x, 0.05 * y, 0.5 + i), yaw(0.2 * turn)}));
    }
    double worst = 0.0, rest = 0.0;
    for (int s = 0; s < 180; ++s) {
      worst = std::max(worst, w.step().worst_overlap);
      if (liveliness(w) > 0.01) rest = w.state().time;
    }
    RecordProperty("worst_overlap_" + std::to_string(seed), std::to_string(worst));
    RecordProperty("rest_" + std::to_string(seed), std::to_string(rest));
    EXPECT_LE(worst, 0.1);  // voxels
    EXPECT_LE(rest, 2.0);   // s
    EXPECT_NEAR(position(w, 10).z(), 9.5, 0.05);
  }
}

TEST(Scene, AHeavyBoxStaysOnALightOne) {
  World w(options_at(0.125));
  w.add(ground(0.5));
  w.add(box("light", {Vec3(0, 0, 0.5), yaw(0.1)}, 0.5, 1.0, 1e3));
  w.add(box("heavy", {Vec3(0.02, 0.01, 1.5)}, 0.5, 1.0, 1e6));
  const double worst = run(w, 3.0);
  EXPECT_LT(worst, 0.1);
  EXPECT_LT(liveliness(w), 0.01);
  EXPECT_LT((position(w, 2) - Vec3(0.02, 0.01, 1.5)).norm(), 0.02);
}

TEST(Scene, ABallDoesNotPassAThinWall) {
  const double h = 0.125, speed = 16 * h / kStep;
  for (int i = 0; i < 8; ++i) {
    World w(options_at(h));
    w.add(obstacle("wall", make_box(Vec3(2 * h, 4, 4)), 0.5));
    w.add(ball("ball", {Vec3(-3 + i * h / 8, 0.01 * i, 0.007 * i), Quat::Identity(), Vec3(speed, 0, 0)}));
    run(w, 0.5);
    EXPECT_LT(position(w, 1).x(), -0.5) << "start " << i;
    EXPECT_LE(velocity(w, 1).norm(), speed + kGravity * 0.5) << "the wall gives no energy";
  }
}

TEST(Scene, AnOverlappingStartReleasesNoMoreThanItsEnergy) {
  for (const double offset : {0.9, 0.6, 0.3, 0.05}) {
    SCOPED_TRACE(offset);
    WorldOptions o = options_at(0.125);
    o.environment.gravity = Vec3::Zero();
    World w(o);
    w.add(box("a", {Vec3(0, 0, 0)}));
    w.add(box("b", {Vec3(0.02, 0.01, offset), yaw(0.2)}));
    double energy = 0.0, most = 0.0;
    for (int s = 0; s < 60; ++s) {
      const StepReport r = w.step();
      if (s == 0) energy = r.contact_energy;
      most = std::max(most, r.kinetic_energy);
      EXPECT_TRUE(r.ok);
    }
    EXPECT_GT(energy, 0.0);
    EXPECT_LE(most, energy);
  }
}

TEST(Scene, APileThatFallsNeverGainsEnergy) {
  std::mt19937 rng(5);
  std::uniform_real_distribution<double> u(-1, 1);
  WorldOptions o = options_at(0.125);
  o.time_step = 1.0 / 240.0;
  World w(o);
  w.add(ground(0.5));
  for (int i = 0; i < 4; ++i) {
    const double x = u(rng), y = u(rng), a = u(rng), b = u(rng), c = u(rng);
    w.add(box("box" + std::to_string(i), {Vec3(0.2 * x, 0.2 * y, 1.2 + 1.6 * i), rotation_from_vector(Vec3(a, b, c))}));
  }
  // Contact holds energy at the start of a step that it may give back within it; nothing more may appear.
  double gain = 0.0, worst = 0.0, before = 0.0, start = 0.0;
  for (int s = 0; s < 720; ++s) {
    const StepReport r = w.step();
    ASSERT_EQ(r.substeps, 1);
    const double now = r.kinetic_energy + r.potential_energy;
    if (s == 0)
      start = now;
    else
      gain += std::max(0.0, now - before - r.contact_energy), worst = std::max(worst, now - before - r.contact_energy);
    before = now;
  }
  RecordProperty("gain_over_start", std::to_string(gain / start));
  RecordProperty("worst_step_over_start", std::to_string(worst / start));
  EXPECT_LT(gain, 1e-3 * start);  // measured 9e-5 in all, 5e-5 in one step, of the fall's energy
}

TEST(Scene, TwoFreeBodiesThatCollideKeepTheirMomentum) {
  WorldOptions o = options_at(0.125);
  o.environment.gravity = Vec3::Zero();
  o.cg_tolerance = 1e-12;
  World w(o);
  w.add(box("a", {Vec3(0, 0, 0), rotation_from_vector(Vec3(0.3, 0.4, 0.1)), Vec3(1, 0, 0.3), Vec3(0.5, -1, 0.4)}));
  w.add(ball("b", {Vec3(1.6, 0.2, 0.1), Quat::Identity(), Vec3(-2, 0.1, 0), Vec3(0, 3, 0)}, 0.5, 0.5, 4000.0));
  const auto momentum = [&](int b) { return w.body(b).linear_momentum(w.v(b)); };
  const auto angular = [&](int b) { return w.body(b).angular_momentum(w.v(b)); };
  const Vec3 P = momentum(0) + momentum(1), L = angular(0) + angular(1);
  const double size = momentum(0).norm() + momentum(1).norm();
  bool touched = false;
  for (int s = 0; s < 60; ++s) {
    const StepReport r = w.step();
    touched = touched || r.worst_overlap > 0.0;
    EXPECT_LT((momentum(0) + momentum(1) - P).norm(), 1e-9 * size);  // the solver's tolerance
    EXPECT_LT((angular(0) + angular(1) - L).norm(), 1e-9 * L.norm());
  }
  ASSERT_TRUE(touched);
  EXPECT_GT((velocity(w, 0) - Vec3(1, 0, 0.3)).norm(), 0.5) << "they did collide";
}

}  // namespace
}  // namespace brim::scenes_test
