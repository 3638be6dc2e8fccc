#include "brim/world/kinematic_motions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "brim/core/parallel.h"
#include "brim/math/rotation.h"
#include "support/edited_worlds.h"

/// Obstacles that are driven between steps.
namespace brim::testing::kinematic_motions_test {
namespace {

constexpr double kStep = 1.0 / 60.0;

Pose at(const Vec3& x, const Vec3& turn = Vec3::Zero()) { return {rotation_from_vector(turn).toRotationMatrix(), x}; }

/// A plate with its top at z = 0, and a box on it.
World belt(Response response, bool sleep = false) {
  WorldOptions o = told(response);
  o.sleep = sleep;
  World w(o);
  w.add(obstacle("plate", make_box(Vec3(8, 2, 0.4)), 0.8, Vec3(0, 0, -0.2)));
  w.add(box("box", {Vec3(0, 0, 0.25)}, 0.8, 0.5));
  return w;
}

WorldOptions weightless(Response response) {
  WorldOptions o = told(response);
  o.environment.gravity = Vec3::Zero();
  return o;
}

/// A paddle, and a ball in front of it, without gravity.
World paddle(Response response) {
  World w(weightless(response));
  w.add(obstacle("paddle", make_box(Vec3(0.2, 1, 1)), 0.0, Vec3(-1, 0, 0)));
  w.add(ball("ball", {Vec3(0, 0, 0)}, 0.0, 0.3));
  return w;
}

TEST(KinematicMotions, ADrivenPlateCarriesABoxByFriction) {
  for (const Response response : {Response::Penalty, Response::Constraint}) {
    World w = belt(response);
    for (int s = 0; s < 30; ++s) w.step();
    w.set_velocity(0, Vec3(0.5, 0, 0), Vec3::Zero());
    EXPECT_EQ(velocity(w, 0), Vec3(0.5, 0, 0));
    const Vec3 before = position(w, 1);
    for (int s = 0; s < 120; ++s) ASSERT_TRUE(w.step().ok);
    EXPECT_NEAR(position(w, 0).x(), 1.0, 1e-12) << "it keeps the velocity that was set once";
    EXPECT_NEAR(velocity(w, 1).x(), 0.5, 0.01);
    // v²/(2 μ g) is lost to the start: 0.016 m.
    EXPECT_NEAR((position(w, 1) - before).x(), 1.0 - 0.5 * 0.5 / (2 * 0.8 * 9.81), 0.02);
    w.set_velocity(0, Vec3::Zero(), Vec3::Zero());
    for (int s = 0; s < 60; ++s) w.step();
    EXPECT_NEAR(velocity(w, 1).norm(), 0.0, 0.01);
    EXPECT_NEAR(position(w, 0).x(), 1.0, 1e-12);
  }
}

TEST(KinematicMotions, ADrivenPaddlePushesABallWithItsVelocity) {
  for (const Response response : {Response::Penalty, Response::Constraint}) {
    World w = paddle(response);
    w.set_velocity(0, Vec3(1.5, 0, 0), Vec3::Zero());
    for (int s = 0; s < 90; ++s) ASSERT_TRUE(w.step().ok);
    if (response == Response::Constraint) {
      EXPECT_NEAR(velocity(w, 1).x(), 1.5, 1e-3);
    }
    EXPECT_GE(velocity(w, 1).x(), 1.5 - 1e-3);
    EXPECT_GT(position(w, 1).x(), position(w, 0).x() + 0.1 + 0.3 - 0.03) << "it is not passed through";
  }
}

TEST(KinematicMotions, ATargetIsReachedAtTheEndOfTheStepWhateverItsSubsteps) {
  const Pose target = at(Vec3(0.3, -0.2, 0.1), Vec3(0.2, 0.5, -0.4));
  for (const int substeps : {1, 3}) {
    WorldOptions o = told();
    o.min_substeps = substeps;
    World w(o);
    w.add(obstacle("paddle", make_box(Vec3(0.2, 1, 1)), 0.5, Vec3(-0.1, 0, 0)));
    w.set_target(0, target);
    EXPECT_NEAR((velocity(w, 0) - (target.translation - Vec3(-0.1, 0, 0)) / kStep).norm(), 0.0, 1e-12);
    const StepReport r = w.step();
    ASSERT_TRUE(r.ok);
    EXPECT_GE(r.substeps, substeps);
    EXPECT_NEAR((position(w, 0) - target.translation).norm(), 0.0, 1e-14);
    const Quat turn(w.q(0)[3], w.q(0)[4], w.q(0)[5], w.q(0)[6]);
    EXPECT_NEAR((turn.toRotationMatrix() - target.rotation).norm(), 0.0, 1e-13);
    const auto there = copy(w.q(0));
    w.step();
    EXPECT_EQ(copy(w.q(0)), there) << "held";
    EXPECT_EQ(velocity(w, 0), Vec3::Zero());
  }
}

TEST(KinematicMotions, TargetsStepByStepAreThePathOfKeyframes) {
  // A slow swing, by keys at the ends of the steps and by targets given before each.
  const auto place = [](double t) { return Vec3(0.5 * (1.0 - std::cos(2.0 * t)), 0.0, -0.2); };
  for (const Response response : {Response::Penalty, Response::Constraint}) {
    World keyed(told(response)), driven = belt(response);
    ObstacleModel m;
    m.shape = make_box(Vec3(8, 2, 0.4));
    m.part.material.friction = 0.8;
    m.keys.clear();
    for (int s = 0; s <= 60; ++s) m.keys.push_back({s * kStep, place(s * kStep), Quat::Identity()});
    keyed.add(named<ObstacleBody>("plate", m));
    keyed.add(box("box", {Vec3(0, 0, 0.25)}, 0.8, 0.5));
    for (int s = 1; s <= 60; ++s) {
      driven.set_target(0, at(place(s * kStep)));
      keyed.step(), driven.step();
      ASSERT_LT((position(keyed, 0) - position(driven, 0)).norm(), 1e-12) << s;
      ASSERT_LT((position(keyed, 1) - position(driven, 1)).norm(), 1e-6) << s;
    }
    EXPECT_GT(position(driven, 1).x(), 0.3);
  }
}

TEST(KinematicMotions, ALongerTargetTakesItsTime) {
  World w(told());
  w.add(obstacle("arm", make_box(Vec3(1, 0.2, 0.2)), 0.5));
  w.set_target(0, at(Vec3(1, 0, 0), Vec3(0, 0, std::numbers::pi / 2)), 0.5);
  for (int s = 0; s < 15; ++s) w.step();
  EXPECT_NEAR(position(w, 0).x(), 0.5, 1e-9);
  EXPECT_NEAR(spin(w, 0).z(), std::numbers::pi, 1e-9);
  EXPECT_NEAR(w.q(0)[6], std::sin(std::numbers::pi / 8), 1e-9);
  for (int s = 0; s < 20; ++s) w.step();
  EXPECT_NEAR((position(w, 0) - Vec3(1, 0, 0)).norm(), 0.0, 1e-12);
  EXPECT_EQ(spin(w, 0), Vec3::Zero());
}

TEST(KinematicMotions, AStateHasThemAndOneFromBeforeHasThemNot) {
  for (const Response response : {Response::Penalty, Response::Constraint}) {
    World w = belt(response);
    for (int s = 0; s < 10; ++s) w.step();
    const State before = w.state();
    w.set_velocity(0, Vec3(0.5, 0.1, 0), Vec3(0, 0, 0.3));
    for (int s = 0; s < 10; ++s) w.step();
    w.set_target(0, at(Vec3(1, 0, -0.2)), 0.5);
    for (int s = 0; s < 10; ++s) w.step();
    const State within = w.state();
    for (int s = 0; s < 30; ++s) w.step();
    const std::uint64_t end = w.hash();

    World other = belt(response);
    other.set_state(within);
    for (int s = 0; s < 30; ++s) other.step();
    EXPECT_EQ(other.hash(), end) << "in another world";
    EXPECT_NEAR(position(other, 0).x(), 1.0, 1e-12);

    w.set_state(before);
    const Vec3 place = position(w, 0);
    for (int s = 0; s < 10; ++s) w.step();
    EXPECT_EQ(position(w, 0), place) << "not driven in that state";
    w.set_state(within);
    for (int s = 0; s < 30; ++s) w.step();
    EXPECT_EQ(w.hash(), end) << "in the same world";
  }
}

TEST(KinematicMotions, TheSameBitsForOneAndTwoThreads) {
  const auto hash = [](int threads) {
    const ThreadLimit limit(threads);
    World w = belt(Response::Constraint);
    w.add(ball("ball", {Vec3(0.2, 0.1, 0.8)}, 0.5, 0.25));
    w.add(obstacle("paddle", make_box(Vec3(0.2, 1, 1)), 0.4, Vec3(-1.5, 0, 0.5)));
    w.set_velocity(0, Vec3(-0.4, 0, 0), Vec3::Zero());
    for (int s = 0; s < 60; ++s) {
      w.set_target(3, at(Vec3(-1.5 + 0.02 * s, 0, 0.5), Vec3(0, 0, 0.01 * s)));
      w.step();
    }
    return w.hash();
  };
  EXPECT_EQ(hash(1), hash(2));
}

TEST(KinematicMotions, ASleeperOnAPlateWakesWhenThePlateIsDriven) {
  World w = belt(Response::Constraint, true);
  for (int s = 0; s < 90; ++s) w.step();
  ASSERT_TRUE(w.asleep(1));
  w.set_velocity(0, Vec3(0.5, 0, 0), Vec3::Zero());
  for (int s = 0; s < 60; ++s) w.step();
  EXPECT_FALSE(w.asleep(1));
  EXPECT_NEAR(velocity(w, 1).x(), 0.5, 0.01);
}

TEST(KinematicMotions, TheyEndKeyframesAndAFrozenObstacleWaits) {
  World w(told());
  ObstacleModel m;
  m.shape = make_box(Vec3::Constant(0.5));
  m.keys = {{0.0, Vec3::Zero(), Quat::Identity()}, {1.0, Vec3(2, 0, 0), Quat::Identity()}};
  w.add(named<ObstacleBody>("cart", m));
  for (int s = 0; s < 30; ++s) w.step();
  EXPECT_NEAR(position(w, 0).x(), 1.0, 1e-9);
  w.set_velocity(0, Vec3(0, 1, 0), Vec3::Zero());
  for (int s = 0; s < 30; ++s) w.step();
  EXPECT_NEAR((position(w, 0) - Vec3(1, 0.5, 0)).norm(), 0.0, 1e-9);
  w.move(0, at(Vec3(0, 0, 1)));
  w.freeze(0);
  EXPECT_NE(message([&] { w.set_velocity(0, Vec3::UnitX(), Vec3::Zero()); }), "");
  EXPECT_NE(message([&] { w.set_target(0, Pose{}); }), "");
  for (int s = 0; s < 30; ++s) w.step();
  EXPECT_NEAR((position(w, 0) - Vec3(1, 0.5, 1)).norm(), 0.0, 1e-9);
  w.freeze(0, false);
  for (int s = 0; s < 30; ++s) w.step();
  EXPECT_NEAR((position(w, 0) - Vec3(1, 1, 1)).norm(), 0.0, 1e-9) << "let go, it goes on";
}

TEST(KinematicMotions, RefuseWhatIsNoObstaclePoseOrTime) {
  World w = belt(Response::Penalty);
  EXPECT_EQ(message([&] { w.set_target(1, Pose{}); }),
            "set_target: 'box' (rigid) moves by forces; obstacles are driven");
  EXPECT_EQ(message([&] {
              w.set_target(0, {2.0 * Mat3::Identity(), Vec3::Zero()});
            }),
            "set_target: 'plate' needs a pose of finite numbers and a rotation");
  EXPECT_EQ(message([&] { w.set_target(0, Pose{}, -1.0); }),
            "set_target: 'plate' is not driven for -1 s; must be a number from 0");
  EXPECT_EQ(message([&] { w.set_target(2, Pose{}); }), "set_target: body 2 is not there; there are 2");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(message([&] { w.set_velocity(0, Vec3(nan, 0, 0), Vec3::Zero()); }), "");
  EXPECT_EQ(velocity(w, 0), Vec3::Zero());
}

TEST(KinematicMotions, MemoryThatIsNoneIsIgnored) {
  World w = belt(Response::Penalty);
  const auto bodies = [&](int) -> Body* { return nullptr; };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  KinematicMotions motions;
  std::vector<double> memory = {-0.1875, 20, 0, 0, 0, nan, 0, 0, 0, 0, 0, 0, 5, 1, 0, 0, 0, 0, 2, 0, 0, 0, 7, 8};
  motions.take(memory, bodies);
  EXPECT_EQ(memory, (std::vector<double>{7, 8}));
  motions.keep(memory);
  EXPECT_EQ(memory, (std::vector<double>{7, 8})) << "neither was a motion";
  memory = {-0.1875, 1e30, 1};
  motions.take(memory, bodies);
  EXPECT_TRUE(memory.empty());
}

}  // namespace
}  // namespace brim::testing::kinematic_motions_test
