#include <gtest/gtest.h>

#include <numbers>

#include "brim/core/error.h"
#include "brim/world/attachment.h"
#include "brim/world/world.h"
#include "support/soft_worlds.h"

/// Laws of what is pulled about by hand (World::grab). For every kind: tests/scene/grab_kinds_test.cpp.
namespace brim::grab_test {
namespace {

using testing::ball;
using testing::options_at;
using testing::position;
using testing::run;

WorldOptions floating(double time_step) {
  WorldOptions o = options_at(0.125);
  o.environment.gravity = Vec3::Zero();
  o.time_step = time_step;
  return o;
}

std::string refused(const std::function<void()>& f) {
  try {
    f();
    return "";
  } catch (const InputError& e) {
    return e.what();
  }
}

TEST(Grab, ABallFollowsThePullAsAHalfDampedOscillatorOfThreeHertz) {
  World w(floating(2e-4));
  w.add(ball("ball", {Vec3(0, 0, 0)}));
  w.grab(0, Vec3::Zero());
  w.pull(Vec3(1, 0, 0));
  const double omega = 2.0 * std::numbers::pi * 3.0, zeta = 0.5, ring = omega * std::sqrt(1.0 - zeta * zeta);
  double worst = 0.0;
  while (w.state().time < 0.5) {
    w.step();
    const double t = w.state().time;
    const double x =
        1.0 - std::exp(-zeta * omega * t) * (std::cos(ring * t) + zeta * omega / ring * std::sin(ring * t));
    worst = std::max(worst, std::abs(position(w, 0).x() - x));
  }
  EXPECT_LT(worst, 5e-3);  // of first order in the step
}

TEST(Grab, AWeightHangsBelowTheHandAndFallsFreelyOnceItIsReleased) {
  WorldOptions o = options_at(0.125);
  World w(o);
  w.add(ball("ball", {Vec3(0, 0, 2)}));
  const double k = 1e4, m = w.body(0).mass();
  w.grab(0, Vec3(0, 0, 2), k, 2.0 * std::sqrt(k * m));
  EXPECT_EQ(w.grabbed(), 0);
  run(w, 4.0);
  EXPECT_NEAR(position(w, 0).z(), 2.0 - m * 9.81 / k, 1e-5);
  w.release();
  EXPECT_EQ(w.grabbed(), -1);
  const double before = testing::velocity(w, 0).z();
  w.step();
  EXPECT_NEAR(testing::velocity(w, 0).z() - before, -9.81 * o.time_step, 1e-9);
}

TEST(Grab, WhatGivesWayIsHeldByTheMatterAboutThePlace) {
  World w(floating(1.0 / 60.0));
  w.add(testing::jelly("jelly", 1.0, Vec3(0, 0, 0)));
  w.grab(0, Vec3(1, 0.5, 0.5));
  w.pull(Vec3(2, 0.5, 0.5));
  run(w, 3.0);
  const Aabb box = w.body(0).bounds(0);
  EXPECT_NEAR(box.hi.x(), 2.0, 0.1) << "the place that was held is where it was pulled";
  EXPECT_NEAR(box.hi.x() - box.lo.x(), 1.0, 0.1) << "and the body came along";
}

/// Two balls that fall on a floor, one of them touched by a hand at a step.
World touched(int at, const std::function<void(World&)>& hand) {
  World w(options_at(0.125));
  w.add(testing::ground(0.5));
  w.add(ball("a", {Vec3(0, 0, 0.7)}));
  w.add(ball("b", {Vec3(0.2, 0, 1.9)}));
  for (int s = 0; s < 60; ++s) {
    if (s == at) hand(w);
    w.step();
  }
  return w;
}

TEST(Grab, AHandThatLetsGoAtOnceLeavesNoTrace) {
  const World never = touched(-1, [](World&) {});
  for (const int at : {0, 30}) {
    const World once = touched(at, [](World& w) {
      w.grab(2, Vec3(0.2, 0, 1.9));
      w.release();
    });
    EXPECT_EQ(once.hash(), never.hash()) << "grabbed at step " << at;
    EXPECT_EQ(once.stiffness(), never.stiffness());
    EXPECT_EQ(once.attachment_count(), 0);
  }
}

TEST(Grab, IsNoPartOfTheStateNorOfReports) {
  World w(options_at(0.125));
  w.add(ball("a", {Vec3(0, 0, 2)}));
  w.add(ball("b", {Vec3(2, 0, 2)}));
  const std::size_t memory = w.state().warm_start.size();
  w.grab(0, Vec3(0, 0, 2));
  EXPECT_TRUE(w.step().links.empty());
  EXPECT_EQ(w.state().warm_start.size(), memory);
  // An attachment that is made meanwhile has its own number and report.
  Attachment pin;
  pin.name = "pin", pin.body = "b", pin.point = Vec3(2, 0, 2);
  EXPECT_EQ(w.attach(pin), 0);
  const StepReport r = w.step();
  ASSERT_EQ(r.links.size(), 1u);
  EXPECT_GT(r.links[0].force.z(), 0.0);
  EXPECT_EQ(w.grabbed(), 0);
  w.release();
  EXPECT_EQ(w.attachment_count(), 1);
  EXPECT_FALSE(w.detached(0));
}

TEST(Grab, SaysWhatCannotBe) {
  World w(options_at(0.125));
  w.add(testing::ground(0.5));
  w.add(ball("ball", {Vec3(0, 0, 2)}));
  const Vec3 at(0, 0, 2);
  EXPECT_EQ(refused([&] { w.grab(0, at); }), "grab: 'ground' does not move");
  EXPECT_EQ(refused([&] { w.grab(7, at); }), "grab: body 7 is not there; there are 2");
  EXPECT_EQ(refused([&] { w.grab(1, Vec3::Constant(NAN)); }), "grab: 'ball' needs a place of finite numbers");
  EXPECT_EQ(refused([&] { w.grab(1, at, -1.0); }),
            "grab: 'ball' is not held with stiffness -1; must be a number from 0");
  EXPECT_EQ(refused([&] { w.pull(at); }), "pull: nothing is grabbed");
  EXPECT_EQ(w.grabbed(), -1);
  w.grab(1, at);
  EXPECT_EQ(refused([&] { w.pull(Vec3::Constant(INFINITY)); }), "pull: the place is not finite");
  EXPECT_NE(refused([&] { w.move(1, {}); }).find("is grabbed; release it first"), std::string::npos);
  EXPECT_NE(refused([&] { w.grab(0, at); }), "");
  EXPECT_EQ(w.grabbed(), 1) << "what cannot be held does not let go of what is";
  w.remove(1);
  EXPECT_EQ(w.grabbed(), -1);
}

}  // namespace
}  // namespace brim::grab_test
