#include "brim/world/sleep.h"

#include <gtest/gtest.h>

#include "brim/body/own/own_body.h"
#include "brim/mesh/primitives.h"
#include "brim/world/applied_force.h"
#include "brim/world/attachment.h"
#include "support/soft_worlds.h"

/// Islands at rest are left out of the step, and come back when something touches them.
namespace brim::testing::sleep_test {
namespace {

WorldOptions sleeping(Response response = Response::Constraint) {
  WorldOptions o = options_at(0.1);
  o.time_step = 1.0 / 120.0;
  o.response = response;
  o.sleep = true;
  return o;
}

/// Three boxes of 0.5 m on each other, and their ground.
void add_tower(World& w, const std::string& name, double x) {
  for (int i = 0; i < 3; ++i) w.add(box(name + std::to_string(i), {Vec3(x, 0, 0.25 + 0.5 * i)}, 0.5, 0.5));
}

int run_until_asleep(World& w, int most) {
  for (int s = 1; s <= most; ++s)
    if (w.step().asleep > 0) return s;
  return -1;
}

TEST(Sleep, ATowerFallsAsleepAfterHalfASecondOfRestAndStays) {
  for (const Response response : {Response::Constraint, Response::Penalty}) {
    World w(sleeping(response));
    w.add(ground(0.5));
    add_tower(w, "box", 0.0);
    const int steps = run_until_asleep(w, 360);
    ASSERT_GE(steps, 60);
    const StepReport asleep = w.step();
    EXPECT_EQ(asleep.asleep, 3);
    EXPECT_EQ(asleep.contacts, 0);
    EXPECT_EQ(asleep.kinetic_energy, 0.0);
    const std::vector<double> q = w.state().q;
    for (int s = 0; s < 50; ++s) w.step();
    EXPECT_EQ(w.state().q, q);
  }
}

TEST(Sleep, UntilThenTheBitsAreThoseWithoutIt) {
  WorldOptions awake = sleeping();
  awake.sleep = false;
  World a(sleeping()), b(awake);
  for (World* w : {&a, &b}) w->add(ground(0.5)), add_tower(*w, "box", 0.0);
  while (a.step().asleep == 0) {
    b.step();
    ASSERT_EQ(a.state().q, b.state().q);
  }
}

TEST(Sleep, TouchWakesTheIslandAndNoOther) {
  World w(sleeping());
  w.add(ground(0.5));
  add_tower(w, "hit", 0.0);
  add_tower(w, "far", 3.0);
  const int ball_body = w.add(ball("ball", {Vec3(0, 0, 14.0)}, 0.5, 0.2));
  bool slept = false;
  for (int s = 0; s < 240 && !(slept && !w.asleep(1)); ++s) slept = w.step().asleep == 6 || slept;
  ASSERT_TRUE(slept);
  ASSERT_FALSE(w.asleep(1));
  EXPECT_FALSE(w.asleep(3));
  EXPECT_TRUE(w.asleep(4));
  EXPECT_NEAR(w.q(ball_body)[2], 1.7, 0.3);
  double lowest = 0.0;
  for (int s = 0; s < 5; ++s) w.step(), lowest = std::min(lowest, w.v(3)[2]);
  EXPECT_LT(lowest, 0.0) << "the blow must have gone through to the topmost box";
}

TEST(Sleep, WhatIsHitMovesAsItWouldHaveAwake) {
  const auto run = [](bool sleep) {
    WorldOptions o = sleeping();
    o.sleep = sleep;
    World w(o);
    w.add(ground(0.5));
    w.add(box("box", {Vec3(0, 0, 0.25)}, 0.5, 0.5));
    w.add(box("thrown", {Vec3(-6.0, 0, 0.25), Quat::Identity(), Vec3(8.0, 0, 0)}, 0.1, 0.5));
    for (int s = 0; s < 240; ++s) w.step();
    return w.q(1)[0];
  };
  const double awake = run(false);
  EXPECT_GT(awake, 0.1);
  EXPECT_NEAR(run(true), awake, 0.02);
}

TEST(Sleep, AResumedRunHasTheSameBits) {
  World a(sleeping()), b(sleeping());
  for (World* w : {&a, &b}) {
    w->add(ground(0.5));
    add_tower(*w, "box", 0.0);
    w->add(ball("ball", {Vec3(0.1, 0, 12.0)}, 0.5, 0.2));
  }
  for (int s = 0; s < 100; ++s) a.step();
  EXPECT_TRUE(a.asleep(1));
  b.set_state(a.state());
  EXPECT_TRUE(b.asleep(1));
  bool woke = false;
  for (int s = 0; s < 150; ++s) {
    a.step(), b.step();
    ASSERT_EQ(a.hash(), b.hash()) << s;
    woke = woke || !a.asleep(1);
  }
  EXPECT_TRUE(woke) << "the ball has come down";
}

TEST(Sleep, AVelocityThatIsSetAndAWordWake) {
  World w(sleeping());
  w.add(ground(0.5));
  add_tower(w, "box", 0.0);
  ASSERT_GT(run_until_asleep(w, 360), 0);
  w.wake(2);
  EXPECT_FALSE(w.asleep(1));
  ASSERT_GT(run_until_asleep(w, 360), 0);
  State s = w.state();
  s.v[s.v.size() - 4] = 1.0;  // the topmost goes up
  w.set_state(s);
  EXPECT_FALSE(w.asleep(1));
  const double before = w.q(3)[2];
  for (int k = 0; k < 5; ++k) w.step();
  EXPECT_GT(w.q(3)[2], before + 0.02);
}

TEST(Sleep, AnObstacleThatSetsOffWakesWhatLiesOnIt) {
  ObstacleModel m;
  m.shape = make_box(Vec3(4, 4, 0.5));
  m.keys = {{0.0, Vec3(0, 0, -0.25)}, {2.0, Vec3(0, 0, -0.25)}, {3.0, Vec3(0, 0, 0.75)}};
  World w(sleeping());
  auto lift = std::make_unique<ObstacleBody>(m);
  lift->set_name("lift");
  w.add(std::move(lift));
  add_tower(w, "box", 0.0);
  ASSERT_GT(run_until_asleep(w, 200), 0);
  for (int s = 0; w.state().time < 3.0; ++s) w.step();
  EXPECT_NEAR(w.q(1)[2], 1.25, 0.05);
}

TEST(Sleep, AForceThatBeginsWakesAndAConstantOneLetsSleep) {
  World w(sleeping());
  w.add(ground(0.2));
  const int b = w.add(box("box", {Vec3(0, 0, 0.5)}, 0.2, 1.0, 2.0));
  AppliedForce push{"push", {"box"}};
  push.force = Vec3(20, 0, 0);
  push.scale = {{2.0, 0.0}, {2.5, 1.0}};
  w.apply(push);
  ASSERT_GT(run_until_asleep(w, 110), 0);
  while (w.state().time < 3.5) w.step();
  EXPECT_FALSE(w.asleep(b));
  EXPECT_GT(velocity(w, b).x(), 1.0);
}

TEST(Sleep, SoftBodiesSleepAndAreWoken) {
  World w(sleeping(Response::Penalty));
  w.add(ground(0.5));
  w.add(jelly("jelly", 0.6, Vec3(0, 0, 0)));
  w.add(ball("ball", {Vec3(0.3, 0.3, 20.0)}, 0.5, 0.2, 300));
  ASSERT_GT(run_until_asleep(w, 230), 0);
  while (w.q(2)[2] > 0.85 && w.state().time < 3.0) w.step();
  w.step();
  EXPECT_FALSE(w.asleep(1));
  double speed = 0.0;
  for (const double v : w.v(1)) speed = std::max(speed, std::abs(v));
  EXPECT_GT(speed, 0.1);
}

TEST(Sleep, LinkedBodiesKeepTheirSlowMotion) {
  WorldOptions o = sleeping();
  o.environment.gravity.setZero();
  World w(o);
  const Vec3 slow(0.005, 0, 0);
  const int a = w.add(box("a", {Vec3(0, 0, 0.5), Quat::Identity(), slow}, 0.2, 0.5));
  w.add(box("b", {Vec3(1, 0, 0.5), Quat::Identity(), slow}, 0.2, 0.5));
  Attachment rope;
  rope.body = "a", rope.to = "b", rope.point = Vec3(0.1, 0, 0.5), rope.to_point = Vec3(0.9, 0, 0.5);
  w.attach(rope);
  for (int s = 0; s < 100; ++s) EXPECT_EQ(w.step().asleep, 0);
  EXPECT_NEAR(w.v(a)[0], slow.x(), 1e-9);
}

/// A ball that stretches along z, q = (height, stretch), and beats from a time on: the goal of its stretch.
class Heart final : public OwnBody {
 public:
  static constexpr double kRadius = 0.5;
  Heart(double begins, double rate) : OwnBody(model()), begins_(begins), rate_(rate) {}
  static OwnModel model() {
    OwnModel m;
    m.q = {kRadius, 1.0};
    m.surface = shapes::icosphere(kRadius, 2);
    m.density = 200.0;
    m.mass_spacing = 0.25;
    m.stiffness_damping = 0.05;
    return m;
  }
  std::string_view kind() const override { return "heart"; }
  Vec3 deform(Coordinates q, const Vec3& X) const override { return {X.x(), X.y(), q[0] + q[1] * X.z()}; }
  Vec3 inverse_deform(Coordinates q, const Vec3& x) const override { return {x.x(), x.y(), (x.z() - q[0]) / q[1]}; }
  double distance(Coordinates q, const Vec3& x) const override { return inverse_deform(q, x).norm() - kRadius; }
  void update(double time, std::span<const double> q, std::span<const double> v) override {
    time_ = time;
    OwnBody::update(time, q, v);
  }
  double energy(Coordinates q) const override {
    const double goal = time_ > begins_ ? 1.0 + 0.2 * std::sin(rate_ * (time_ - begins_)) : 1.0;
    return 2e4 * (q[1] - goal) * (q[1] - goal);
  }

 private:
  double begins_, rate_, time_ = 0.0;
};

TEST(Sleep, ABodyThatBeginsToBeatWakesWithWhatLiesOnIt) {
  World w(sleeping());
  w.add(ground(0.5));
  const int heart = w.add(std::make_unique<Heart>(3.0, 6.0));
  const int on_top = w.add(box("box", {Vec3(0, 0, 1.2)}, 0.3, 0.5));
  while (w.state().time < 2.9) w.step();
  ASSERT_TRUE(w.asleep(heart));
  ASSERT_TRUE(w.asleep(on_top));
  const double before = w.q(on_top)[2];
  double highest = before, lowest = before;
  while (w.state().time < 4.5) {
    EXPECT_TRUE(w.step().ok);
    highest = std::max(highest, w.q(on_top)[2]), lowest = std::min(lowest, w.q(on_top)[2]);
    if (w.state().time > 3.05) {
      EXPECT_FALSE(w.asleep(heart)) << w.state().time;
    }
  }
  EXPECT_GT(highest - lowest, 0.1) << "0.2 radii up and down";
}

TEST(Sleep, ABodyThatMovesByItselfMoreSlowlyThanWhatSleepsStaysAwake) {
  World w(sleeping());
  const int heart = w.add(ground(0.5)) + 1;
  w.add(std::make_unique<Heart>(0.0, 0.01));  // its vertices move by up to 1 mm/s
  double after_a_second = 0.0;
  for (int s = 0; s < 240; ++s) {
    if (s == 120) after_a_second = w.q(heart)[1];
    w.step();
    ASSERT_FALSE(w.asleep(heart)) << s;
  }
  EXPECT_NEAR(w.q(heart)[1] - after_a_second, 0.2 * 0.01, 2e-4) << "as its goal, from 1 s to 2 s";
}

TEST(Sleep, ARunThatIsResumedBeforeABodyBeginsToBeatHasTheSameBits) {
  const auto made = [] {
    auto w = std::make_unique<World>(sleeping());
    w->add(ground(0.5));
    w->add(std::make_unique<Heart>(2.5, 6.0));
    return w;
  };
  const auto a = made(), b = made();
  while (a->state().time < 2.3) a->step();
  ASSERT_TRUE(a->asleep(1));
  b->set_state(a->state());
  for (int s = 0; s < 100; ++s) {
    a->step(), b->step();
    ASSERT_EQ(a->hash(), b->hash()) << s;
  }
  EXPECT_FALSE(a->asleep(1));
}

TEST(Sleep, FluidsNeverSleep) {
  World w(sleeping(Response::Penalty));
  w.add(ground(0.5));
  w.add(blob("water", 3, 0.1, Vec3(0, 0, 0.1)));
  EXPECT_EQ(run_until_asleep(w, 200), -1);
}

}  // namespace
}  // namespace brim::testing::sleep_test
