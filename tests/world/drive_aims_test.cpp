#include "brim/world/drive_aims.h"

#include <gtest/gtest.h>

#include <cmath>

#include "brim/body/articulated/articulated_body.h"
#include "brim/core/error.h"
#include "brim/world/world.h"

/// Drives of articulated bodies that are aimed between steps, and what states keep of that.
namespace brim::drive_aims_test {
namespace {

constexpr double kStep = 1.0 / 240.0;

/// Two hinges about y with drives, the second with keyframes, and a third without a drive.
ArticulatedModel arm() {
  ArticulatedModel m;
  for (int i = 0; i < 3; ++i) {
    LinkModel l;
    l.name = "link" + std::to_string(i);
    l.joint.name = i == 0 ? "shoulder" : i == 1 ? "elbow" : "wrist";
    l.parent = i - 1;
    l.joint.kind = JointKind::Revolute;
    l.joint.axis = Vec3(0, 1, 0);
    if (i > 0) l.joint.position = Vec3(0.3, 0, 0);
    l.mass = 1.0;
    l.center_of_mass = Vec3(0.15, 0, 0);
    l.inertia = 0.01 * Mat3::Identity();
    if (i < 2) l.joint.drive.stiffness = 2e3, l.joint.drive.damping = 60;
    if (i == 2) l.joint.damping = 0.5;
    if (i == 1) l.joint.drive.keys = {{0.0, 0.0}, {1.0, 1.0}};
    m.links.push_back(std::move(l));
  }
  return m;
}

World world_with_arm(bool gravity = false) {
  WorldOptions o;
  o.time_step = kStep;
  if (!gravity) o.environment.gravity = Vec3::Zero();
  World w(o);
  auto body = std::make_unique<ArticulatedBody>(arm());
  body->set_name("arm");
  w.add(std::move(body));
  return w;
}

void run(World& w, int steps) {
  for (int i = 0; i < steps; ++i) w.step();
}

TEST(DriveAims, AnAimedJointGoesThereAndStaysWithKeyframesOrWithout) {
  World w = world_with_arm();
  ASSERT_EQ(w.drives(0).size(), 2u);
  EXPECT_EQ(w.drives(0)[1], "elbow");
  run(w, 60);
  EXPECT_NEAR(w.q(0)[1], 0.25, 5e-3) << "by its keyframes";
  w.set_drive(0, "elbow", -0.4, 0.0);
  w.set_drive(0, 0, 0.7, 0.0);
  run(w, 480);
  EXPECT_NEAR(w.q(0)[0], 0.7, 1e-4);
  EXPECT_NEAR(w.q(0)[1], -0.4, 1e-4);
}

TEST(DriveAims, AllAtOnceAreTheSameBitsAsOneByOne) {
  World one = world_with_arm(true), all = world_with_arm(true);
  for (int i = 0; i < 30; ++i) {
    const std::array<double, 2> q = {0.01 * i, -0.02 * i}, v = {0.01 / kStep, -0.02 / kStep};
    one.set_drive(0, 1, q[1], v[1]);
    one.set_drive(0, 0, q[0], v[0]);
    all.set_drives(0, q, v);
    one.step();
    all.step();
  }
  EXPECT_EQ(one.hash(), all.hash());
  EXPECT_NEAR(one.q(0)[0], 0.29, 0.05);
}

TEST(DriveAims, AStateHasThemSoThatARestoredWorldGoesOnWithTheSameBits) {
  World w = world_with_arm(true);
  const State first = w.state();
  run(w, 20);
  const State before = w.state();
  run(w, 20);
  const std::uint64_t by_keyframes = w.hash();
  w.set_state(before);
  w.set_drives(0, std::vector<double>{0.5, 0.1});
  run(w, 20);
  const State aimed = w.state();
  run(w, 20);
  const std::uint64_t with_aims = w.hash();
  w.set_state(before);
  run(w, 20);
  EXPECT_EQ(w.hash(), by_keyframes) << "an earlier state undoes the aim";
  w.set_state(aimed);
  run(w, 20);
  EXPECT_EQ(w.hash(), with_aims) << "and a later one brings it back";
  World other = world_with_arm(true);
  other.set_state(aimed);
  run(other, 20);
  EXPECT_EQ(other.hash(), with_aims) << "in a world that never was aimed, too";
  w.set_state(first);
  run(w, 40);
  EXPECT_EQ(w.hash(), by_keyframes);
}

TEST(DriveAims, AWorldThatIsAimedAtWhatItHasMovesAsBefore) {
  ArticulatedModel m = arm();
  m.links[0].joint.drive.target = 0.3;
  m.links[1].joint.drive.keys.clear();
  WorldOptions o;
  o.time_step = kStep;
  World given(o), aimed(o);
  for (World* w : {&given, &aimed}) w->add(std::make_unique<ArticulatedBody>(m));
  aimed.set_drives(0, std::vector<double>{0.3, 0.0});
  run(given, 30), run(aimed, 30);
  EXPECT_TRUE(std::ranges::equal(given.q(0), aimed.q(0)));
  EXPECT_TRUE(std::ranges::equal(given.v(0), aimed.v(0)));
}

TEST(DriveAims, WhatCannotBeIsRefusedWithNames) {
  World w = world_with_arm();
  const auto says = [&](const auto& f, const std::string& words) {
    try {
      f();
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find(words), std::string::npos) << e.what();
      return;
    }
    ADD_FAILURE() << "nothing was thrown: " << words;
  };
  const std::uint64_t before = w.hash();
  says([&] { w.set_drive(0, "wrist", 0, 0); },
       "'arm' has no drive at \"wrist\"; its drives are \"shoulder\", \"elbow\"");
  says([&] { w.set_drive(0, 2, 0.0, 0.0); }, "has no drive 2; it has 2");
  says([&] { w.set_drive(0, "elbow", std::nan(""), 0); }, "position nan of \"elbow\" of 'arm'");
  says([&] { w.set_drives(0, std::vector<double>{1, 2, 3}); }, "3 positions are not allowed for 'arm'; its 2 drives");
  says([&] { w.set_drives(0, std::vector<double>{1, 2}, std::vector<double>{1}); }, "1 velocities");
  says([&] { w.set_drive(1, "elbow", 0, 0); }, "body 1 is not there");
  EXPECT_EQ(w.hash(), before);
  w.remove(0);
  says([&] { w.set_drive(0, "elbow", 0, 0); }, "was removed");
}

TEST(DriveAims, DamagedMemoryAimsNothingThatIsNotThere) {
  ArticulatedBody body(arm());
  const DriveAims::Bodies one = [&](int b) -> Body* { return b == 0 ? &body : nullptr; };
  DriveAims aims;
  std::vector<double> memory = {-0.375, 12, 0, 1, 0.5, 0, 7, 0, 1, 1, 0, 99, std::nan(""), 0, 42.0};
  aims.take(memory, one);
  EXPECT_EQ(memory, std::vector<double>{42.0});
  EXPECT_EQ(body.drive(1).target, 0.5);
  EXPECT_TRUE(body.drive(1).keys.empty());
  memory = {-0.375, 1e300, 3.0};
  aims.take(memory, one);
  EXPECT_TRUE(memory.empty());
  EXPECT_EQ(body.drive(1).keys.size(), 2u) << "as described again";
}

}  // namespace
}  // namespace brim::drive_aims_test
