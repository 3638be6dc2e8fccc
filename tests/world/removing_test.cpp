#include <gtest/gtest.h>

#include "brim/world/attachment.h"
#include "support/edited_worlds.h"

/// That a world from which bodies are taken goes on as if it had been made so.
namespace brim::testing::removing_test {
namespace {

/// The same bodies in both, but for `extra`, which a has as number 1.
void expect_equal_but(const World& a, const World& b) {
  for (int i = 0; i < b.body_count(); ++i) {
    const int j = i == 0 ? 0 : i + 1;
    ASSERT_EQ(a.body(j).name(), b.body(i).name());
    ASSERT_EQ(copy(a.q(j)), copy(b.q(i))) << b.body(i).name();
    ASSERT_EQ(copy(a.v(j)), copy(b.v(i))) << b.body(i).name();
  }
}

TEST(Remove, OthersStepBitForBitAsIfTheBodyHadNeverBeen) {
  struct Case {
    Response response;
    void (*add)(World&);
    bool sleep;
  };
  for (const Case& c : {Case{Response::Penalty, add_soft, false}, Case{Response::Constraint, add_soft, false},
                        Case{Response::Constraint, add_rigid, false}, Case{Response::Penalty, add_rigid, false},
                        Case{Response::Constraint, add_rigid, true}}) {
    WorldOptions o = told(c.response);
    o.sleep = c.sleep;
    World a(o), b(o);
    a.add(ground(0.5)), b.add(ground(0.5));
    a.add(jelly("extra", 0.37, Vec3(-0.3, 0.1, 0.2)));
    c.add(a), c.add(b);
    a.remove(1);
    EXPECT_TRUE(a.removed(1));
    EXPECT_EQ(a.body_count(), b.body_count() + 1);
    for (int s = 0; s < 25; ++s) {
      const StepReport ra = a.step(), rb = b.step();
      expect_equal_but(a, b);
      ASSERT_EQ(ra.contacts, rb.contacts);
      ASSERT_EQ(ra.cg_iterations, rb.cg_iterations);
      if (HasFatalFailure()) return;
    }
  }
}

TEST(Remove, InTheMiddleOfContactTheOthersGoOnAsFromTheirStatesAlone) {
  World a(told()), b(told());
  a.add(ground(0.5)), b.add(ground(0.5));
  a.add(box("extra", {Vec3(0.05, 0, 1.1)}, 0.5, 0.3));
  add_soft(a), add_soft(b);
  for (int s = 0; s < 12; ++s) a.step();
  const Vec3 before = a.body(3).linear_momentum(a.v(3));
  a.remove(1);
  EXPECT_EQ(a.body(3).linear_momentum(a.v(3)), before);
  b.step();  // its stiffness is told, nothing else is chosen at the start
  State s;
  s.time = a.state().time, s.step = a.state().step;
  for (int i = 0; i < a.body_count(); ++i) {
    if (i == 1) continue;
    s.q.insert(s.q.end(), a.q(i).begin(), a.q(i).end());
    s.v.insert(s.v.end(), a.v(i).begin(), a.v(i).end());
  }
  b.set_state(s);
  for (int i = 0; i < 15; ++i) {
    a.step(), b.step();
    expect_equal_but(a, b);
    if (HasFatalFailure()) return;
  }
}

TEST(Remove, EditsInARowAreWhatTheyAreWithTheStateReadAfterEach) {
  for (const bool sleep : {false, true}) {
    WorldOptions o = told(Response::Constraint);
    o.sleep = sleep;
    World a(o), b(o);
    for (World* w : {&a, &b}) {
      w->add(ground(0.5));
      for (int i = 0; i < 12; ++i) w->add(ball("ball" + std::to_string(i), {Vec3(0.7 * i, 0, 0.3)}, 0.5, 0.3));
      for (int s = 0; s < 40; ++s) w->step();
    }
    Material ice;
    ice.name = "ice", ice.friction = 0.01;
    const std::vector<std::function<void(World&)>> edits = {
        [](World& w) { w.remove(3); },
        [](World& w) { w.freeze(5); },
        [](World& w) { w.remove(1); },
        [&](World& w) { w.set_material(7, ice); },
        [](World& w) { w.set_velocity(8, Vec3(1, 0, 0), Vec3::Zero()); },
        [](World& w) { w.remove(12); },
        [](World& w) { w.add(ball("late", {Vec3(0, 3, 0.3)}, 0.5, 0.3)); },
        [](World& w) { w.remove(13); },
        [](World& w) {
          w.set_touch({"ball6", "ground", false});
        },
        [](World& w) { w.set_gravity(Vec3(0, 0.5, -9)); },
        [](World& w) { w.freeze(5, false); }};
    for (const auto& edit : edits) {
      edit(a), edit(b);
      EXPECT_EQ(b.state().q.size(), b.state().v.size() / 6 * 7);
    }
    EXPECT_TRUE(a.removed(13) && a.removed(1) && !a.removed(2));
    EXPECT_EQ(copy(a.v(3)), std::vector<double>(6, 0.0));
    ASSERT_EQ(a.hash(), b.hash());
    for (int s = 0; s < 20; ++s) {
      a.step(), b.step();
      ASSERT_EQ(a.hash(), b.hash()) << s;
    }
  }
}

TEST(Remove, AnEarlierStateBringsTheBodyBackBitForBit) {
  for (const Response response : {Response::Penalty, Response::Constraint}) {
    World a(told(response)), b(told(response));
    for (World* w : {&a, &b}) w->add(ground(0.5)), add_rigid(*w);
    for (int s = 0; s < 8; ++s) a.step(), b.step();
    const State before = a.state();
    a.remove(2);
    a.remove(4);
    for (int s = 0; s < 8; ++s) a.step();
    EXPECT_GT(a.q(2)[2], 0.5) << "it is kept where it was";
    a.set_state(before);
    EXPECT_FALSE(a.removed(2));
    for (int s = 0; s < 10; ++s) {
      a.step(), b.step();
      ASSERT_EQ(a.hash(), b.hash());
    }
  }
}

TEST(Remove, WhatLayOnItFallsAndWhatSleptThereWakes) {
  WorldOptions o = told(Response::Constraint);
  o.time_step = 1.0 / 120.0;
  o.sleep = true;
  World w(o);
  w.add(ground(0.5));
  w.add(box("lower", {Vec3(0, 0, 0.25)}, 0.5, 0.5));
  w.add(box("upper", {Vec3(0, 0, 0.75)}, 0.5, 0.5));
  for (int s = 0; s < 300 && !w.asleep(2); ++s) w.step();
  ASSERT_TRUE(w.asleep(2));
  w.remove(1);
  EXPECT_FALSE(w.asleep(2));
  for (int s = 0; s < 120; ++s) w.step();
  EXPECT_NEAR(w.q(2)[2], 0.25, 0.02);
  for (int s = 0; s < 300 && !w.asleep(2); ++s) w.step();
  ASSERT_TRUE(w.asleep(2));
  w.remove(0);  // the ground
  EXPECT_FALSE(w.asleep(2));
  for (int s = 0; s < 30; ++s) w.step();
  EXPECT_LT(w.q(2)[2], 0.0);
}

TEST(Remove, WhatHeldToItIsDetachedAndItsForcesEnd) {
  World w(told());
  w.add(box("post", {Vec3(0, 0, 1)}, 0.5, 0.2));
  w.add(box("weight", {Vec3(0, 0, 0.7)}, 0.5, 0.2));
  Attachment a;
  a.name = "pin", a.body = "post", a.point = Vec3(0, 0, 1);
  w.attach(a);
  a.name = "rope", a.to = "weight", a.point = Vec3(0, 0, 0.9), a.to_point = Vec3(0, 0, 0.8);
  w.attach(a);
  for (int s = 0; s < 5; ++s) w.step();
  w.remove(0);
  EXPECT_TRUE(w.detached(0));
  EXPECT_TRUE(w.detached(1));
  const double z = w.q(1)[2];
  for (int s = 0; s < 30; ++s) w.step();
  EXPECT_NEAR(w.q(1)[2], z - 0.5 * 9.81 * 0.25, 0.1);
  a.name = "late", a.to.clear(), a.to_point.reset();
  EXPECT_NE(message([&] { w.attach(a); }).find("\"post\" was removed"), std::string::npos);
}

}  // namespace
}  // namespace brim::testing::removing_test
