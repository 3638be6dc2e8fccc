#include "brim/world/links.h"

#include <gtest/gtest.h>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/world/space.h"
#include "support/momentum.h"
#include "support/soft_worlds.h"

/// Laws of attachments between bodies and to space. Those for every kind: tests/scene/links_test.cpp.
namespace brim::links_test {
namespace {

using testing::ball;
using testing::box;
using testing::Momentum;
using testing::momentum;
using testing::named;
using testing::options_at;
using testing::position;
using testing::run;
using testing::velocity;

constexpr double kGravity = 9.81;

WorldOptions floating(double time_step = 1.0 / 60.0) {
  WorldOptions o = options_at(0.125);
  o.environment.gravity = Vec3::Zero();
  o.time_step = time_step;
  return o;
}

Attachment at(std::string name, std::string body, std::string to, const Vec3& x, double k = 0.0, double d = 0.0) {
  Attachment a;
  a.name = std::move(name), a.body = std::move(body), a.to = std::move(to);
  a.point = x, a.stiffness = k, a.damping = d;
  return a;
}

TEST(Links, ABallOnASpringHangsWhereTheSpringCarriesItsWeight) {
  World w(options_at(0.125));
  w.add(ball("ball", {Vec3(0, 0, 2)}));
  const double m = w.body(0).mass(), k = 1e5;
  w.attach(at("spring", "ball", "", Vec3(0, 0, 2), k, 2.0 * std::sqrt(k * m)));
  run(w, 3.0);
  EXPECT_NEAR(position(w, 0).z(), 2.0 - m * kGravity / k, 1e-6);
  const StepReport r = w.step();
  ASSERT_EQ(r.links.size(), 1u);
  EXPECT_NEAR(r.links[0].force.z(), m * kGravity, 1e-3 * m * kGravity);
  EXPECT_NEAR(r.links[0].error, m * kGravity / k, 1e-6);
}

TEST(Links, ABallOnASpringSwingsWithItsFrequency) {
  World w(floating(1e-3));
  w.add(ball("ball", {Vec3(0, 0, 0), Quat::Identity(), Vec3(1, 0, 0)}));
  const double m = w.body(0).mass(), k = m * std::pow(2.0 * std::numbers::pi, 2);  // one swing a second
  w.attach(at("spring", "ball", "", Vec3::Zero(), k));
  double crossed = 0.0;
  for (int s = 0; s < 1100 && crossed == 0.0; ++s) {
    const double before = position(w, 0).x();
    w.step();
    if (before < 0.0 && position(w, 0).x() >= 0.0) crossed = w.state().time;
  }
  EXPECT_NEAR(crossed, 1.0, 2e-3);
}

TEST(Links, TheEnergyOfASpringIsPartOfTheReports) {
  // Backward Euler takes exp(−ω² dt t) of the energy of a swing, and nothing else does.
  World w(floating(1e-3));
  w.add(ball("ball", {Vec3(0, 0, 0), Quat::Identity(), Vec3(1, 0, 0)}));
  const double m = w.body(0).mass(), omega = 2.0 * std::numbers::pi;
  w.attach(at("spring", "ball", "", Vec3::Zero(), m * omega * omega));
  for (int s = 1; s <= 600; ++s) {
    const StepReport r = w.step();
    const double want = 0.5 * m * std::exp(-omega * omega * 1e-3 * w.state().time);
    ASSERT_NEAR(r.kinetic_energy + r.potential_energy, want, 5e-3 * 0.5 * m) << s;
  }
}

TEST(Links, ASlackRopeHasNone) {
  World w(floating(1e-3));
  w.add(ball("ball", {Vec3(0, 0, 0), Quat::Identity(), Vec3(-1, 0, 0)}));
  Attachment rope = at("rope", "ball", "", Vec3::Zero(), 1e4);
  rope.to_point = Vec3(-1, 0, 0), rope.length = 1.0, rope.pulls_only = true;
  w.attach(rope);
  EXPECT_EQ(w.step().potential_energy, 0.0);
  for (int s = 0; s < 2200; ++s) w.step();  // through the middle, and to its end on the other side
  const StepReport r = w.step();
  EXPECT_GT(r.potential_energy, 0.0);
  EXPECT_NEAR(r.potential_energy, 0.5 * 1e4 * std::pow(r.links[0].error, 2), 0.05 * r.potential_energy);
}

TEST(Links, WhatLinksGiveIsEqualAndOppositeToRoundingAndBodiesKeepTheirMomentum) {
  for (const double k : {0.0, 3e4}) {
    World w(floating());
    w.add(box("a", {Vec3(0, 0, 0), Quat::Identity(), Vec3(1, 0.3, 0), Vec3(0, 0, 2)}));
    w.add(testing::jelly("b", 1.0, Vec3(0.6, -0.5, -0.5)));
    w.set_touch({"*", "*", false});
    w.attach(at("edge", "a", "b", Vec3(0.6, 0.1, 0.1), k, 30.0));
    w.attach(at("corner", "b", "a", Vec3(0.7, -0.4, 0.4), k, 30.0));
    const Momentum start = momentum(w);
    double worst = 0.0;
    for (int s = 0; s < 60; ++s) {
      const StepReport r = w.step();
      ASSERT_TRUE(r.ok);
      EXPECT_TRUE(r.warnings.empty()) << r.warnings[0].message;
      EXPECT_LT(r.momentum_error, 1e-12);
      EXPECT_LT(r.angular_error, 1e-12);
      const Momentum now = momentum(w);
      worst = std::max(worst, (now.linear - start.linear).norm() / start.linear.norm());
      if (s == 59) {
        // The own sub-steps of a spinning body add to angular momentum what they always do.
        EXPECT_LT((now.angular - start.angular).norm() / start.angular.norm(), 0.02);
      }
    }
    EXPECT_LT(worst, 1e-9) << "what the solve leaves, k = " << k;
  }
}

TEST(Links, ARigidOneYieldsByWhatItsDocumentationSays) {
  World w(options_at(0.125));
  w.add(ball("ball", {Vec3(0, 0, 2)}));
  w.attach(at("pin", "ball", "", Vec3(0, 0, 2)));
  run(w, 1.0);
  const double dt = w.options().time_step;
  EXPECT_NEAR(2.0 - position(w, 0).z(), kGravity * dt * dt / Links::kRigid, 1e-9);
}

TEST(Links, APendulumOnARigidPointHasItsPeriod) {
  WorldOptions o = options_at(0.125);
  o.time_step = 1.0 / 240.0;
  World w(o);
  const double length = 2.0, angle = 0.1;
  w.add(ball("bob", {length * Vec3(std::sin(angle), 0, -std::cos(angle))}, 0.5, 0.2));
  w.attach(at("pivot", "bob", "", Vec3::Zero()));
  // A ball of radius r about a point at l: I = m l² + 2/5 m r².
  const double period = 2.0 * std::numbers::pi * std::sqrt((length * length + 0.4 * 0.04) / (kGravity * length));
  std::vector<double> crossings;
  while (w.state().time < 1.2 * period) {
    const double before = position(w, 0).x(), t = w.state().time;
    w.step();
    const double now = position(w, 0).x();
    if ((before < 0.0) != (now < 0.0)) crossings.push_back(t + o.time_step * before / (before - now));
  }
  ASSERT_GE(crossings.size(), 2u);
  EXPECT_NEAR(2.0 * (crossings[1] - crossings[0]), period, 0.01 * period);
}

TEST(Links, OneBreaksAboveItsForceAndStaysBrokenWhereTheRunIsTakenUp) {
  WorldOptions o = options_at(0.125);
  o.sleep = true;
  const auto make = [&] {
    auto w = std::make_unique<World>(o);
    w->add(ball("ball", {Vec3(0, 0, 50)}));
    w->add(box("box", {Vec3(3, 0, 50)}));
    Attachment a = at("thread", "ball", "", Vec3(0, 0, 50), 1e4);
    a.break_force = 0.9 * w->body(0).mass() * kGravity;
    w->attach(a);
    w->attach(at("pin", "box", "", Vec3(3, 0, 50)));
    return w;
  };
  auto w = make();
  bool said = false;
  for (int s = 0; s < 60; ++s)
    for (const Warning& warning : w->step().warnings) said = said || warning.code == "link_broken";
  EXPECT_TRUE(said);
  EXPECT_TRUE(w->detached(0));
  EXPECT_FALSE(w->detached(1));
  EXPECT_NEAR(velocity(*w, 0).z(), -9.81 * w->state().time, 5.0);
  auto again = make();
  again->set_state(w->state());
  EXPECT_TRUE(again->detached(0));
  for (int s = 0; s < 20; ++s) w->step(), again->step();
  EXPECT_EQ(w->hash(), again->hash());
}

TEST(Links, ManyThatBreakAtOnceAreNamedUpToSixteenAndCounted) {
  World w(options_at(0.125));
  constexpr int kBalls = 19;
  for (int i = 0; i < kBalls; ++i) {
    const Vec3 at_rest(3.0 * i, 0, 50);
    w.add(ball(fmt::format("ball_{}", i), {at_rest}));
    Attachment a = at(fmt::format("thread_{}", i), fmt::format("ball_{}", i), "", at_rest, 1e4);
    a.break_force = 1e-6 * w.body(i).mass();
    w.attach(a);
  }
  std::vector<std::string> said;
  for (int s = 0; s < 10; ++s)
    for (const Warning& warning : w.step().warnings)
      if (warning.code == "link_broken") said.push_back(warning.message);
  for (int i = 0; i < kBalls; ++i) EXPECT_TRUE(w.detached(i)) << i;
  ASSERT_EQ(said.size(), 17u);
  EXPECT_EQ(said.back(), "and 3 more broke at the same time; the run's links say which");
}

TEST(Links, ARopeIsSlackUntilItIsAsLongAsItIs) {
  World w(options_at(0.125));
  w.add(ball("ball", {Vec3(0, 0, 0)}, 0.5, 0.2));
  Attachment a = at("rope", "ball", "", Vec3::Zero());
  a.to_point = Vec3(0, 0, 0.5), a.length = 1.0, a.pulls_only = true;
  w.attach(a);
  run(w, 0.25);
  EXPECT_NEAR(velocity(w, 0).z(), -kGravity * w.state().time, 1e-9);
  run(w, 2.0);
  EXPECT_NEAR(position(w, 0).z(), -0.5, 1e-4);
}

TEST(Links, ATargetInSpaceThatMovesTakesItsBodyAlong) {
  World w(floating());
  w.add(ball("ball", {Vec3::Zero()}));
  Attachment a = at("hand", "ball", "", Vec3::Zero());
  a.motion = [](double t, const Vec3& x, const Vec3&) -> Vec3 { return x + Vec3(std::sin(t), 0, 0.5 * t); };
  w.attach(a);
  run(w, 1.0);
  EXPECT_LT((position(w, 0) - Vec3(std::sin(1.0), 0, 0.5)).norm(), 1e-4);
  EXPECT_NEAR(velocity(w, 0).x(), std::cos(1.0), 0.01);
}

TEST(Links, BodiesThatAreToldNotToTouchDoNot) {
  World w(floating());
  w.add(box("a", {Vec3(0, 0, 0)}));
  w.add(box("b", {Vec3(0.8, 0, 0)}));
  Attachment a = at("glue", "a", "b", Vec3(0.4, 0, 0));
  a.touch = false;
  w.attach(a);
  EXPECT_EQ(w.step().contacts, 0);
  w.detach(0);
  w.step();
  EXPECT_GT(w.step().contacts, 0);
}

TEST(Links, TheBitsAreTheSameForAnyNumberOfThreads) {
  std::vector<std::uint64_t> hashes;
  for (const int threads : {1, 3}) {
    const ThreadLimit limit(threads);
    World w(options_at(0.1));
    w.add(testing::ground(0.5));
    w.add(testing::jelly("jelly", 0.6, Vec3(0, 0, 0.8)));
    w.add(testing::sheet("sheet", 1.0, Vec3(0.3, 0.3, 1.6)));
    Attachment a;
    a.name = "edge", a.body = "sheet", a.to = "jelly", a.stiffness = 500.0;
    a.region = [](const Vec3& x) { return x.x() < 0.0; };
    w.attach(a);
    w.attach(at("nail", "sheet", "", Vec3(0.8, 0.8, 1.6)));
    for (int s = 0; s < 30; ++s) ASSERT_TRUE(w.step().ok);
    hashes.push_back(w.hash());
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(Links, WhatCannotBeIsRefusedAndNothingIsAdded) {
  World w(floating());
  w.add(testing::ground(0.5));
  w.add(box("box", {Vec3(0, 0, 2)}));
  const auto refused = [&](const Attachment& a, const std::string& word) {
    try {
      w.attach(a);
      ADD_FAILURE() << word;
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find(word), std::string::npos) << e.what();
    }
    EXPECT_EQ(w.attachment_count(), 0);
  };
  refused(at("x", "bix", "", Vec3::Zero()), "bix");
  refused(at("x", "ground", "", Vec3::Zero()), "neither side can move");
  refused(at("x", "box", "", Vec3::Zero(), -1.0), "stiffness");
  Attachment a = at("x", "box", "", Vec3::Zero());
  a.point.reset();
  refused(a, "exactly one");
  a.region = [](const Vec3&) { return false; };
  refused(a, "no point");
}

TEST(World, ABodyThatThrowsWhileItIsTakenInLeavesTheWorldAsItWas) {
  struct Bad : Space {
    void update(double, std::span<const double>, std::span<const double>) override { throw InputError("bad"); }
    std::size_t q_size() const override { return 3; }
    std::size_t v_size() const override { return 3; }
  };
  World w(floating());
  w.add(box("box", {Vec3(0, 0, 2)}));
  const std::uint64_t before = w.hash();
  EXPECT_THROW(w.add(named<Bad>("bad")), InputError);
  EXPECT_EQ(w.hash(), before);
  EXPECT_EQ(w.body_count(), 1);
  w.add(box("bad", {Vec3(3, 0, 2)}));  // its name is free
  EXPECT_TRUE(w.step().ok);
}

}  // namespace
}  // namespace brim::links_test
