#include <gtest/gtest.h>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/world/links.h"
#include "support/momentum.h"
#include "support/soft_worlds.h"

/// Laws of attachments, joints and forces that hold particles of a fluid. Those for every kind:
/// tests/scene/links_test.cpp.
namespace brim::loose_links_test {
namespace {

using testing::blob;
using testing::box;
using testing::Momentum;
using testing::momentum;
using testing::options_at;
using testing::run;

constexpr double kSpacing = 0.1;
/// Share of the momentum at the start that solves may lose. A fluid's own products are in single precision, and it
/// weighs up to 200 times what brings the momentum.
constexpr double kSolve = 1e-6;

WorldOptions floating() {
  WorldOptions o = options_at(0.05);
  o.environment.gravity = Vec3::Zero();
  return o;
}

/// A cube of n³ particles with a corner at the origin, at rest.
std::unique_ptr<Body> drop(const std::string& name, int n = 4, const Vec3& corner = Vec3::Zero()) {
  return blob(name, n, kSpacing, corner);
}

/// Place of particle (i, j, k) of a drop of n³.
Vec3 particle(int i, int j, int k, const Vec3& corner = Vec3::Zero()) {
  return corner + kSpacing * Vec3(i + 0.5, j + 0.5, k + 0.5);
}

Vec3 place(const World& w, int b, int particle) {
  return Eigen::Map<const Vec3>(w.q(b).data() + 3 * static_cast<std::size_t>(particle));
}

Attachment glue(std::string body, std::string to) {
  Attachment a;
  a.name = "glue", a.body = std::move(body), a.to = std::move(to), a.touch = false;
  return a;
}

TEST(LooseLinks, APinnedParticleStaysWhereTheOthersFall) {
  World w(options_at(0.05));
  w.add(drop("drop", 1));
  w.add(drop("free", 1, Vec3(2, 0, 0)));
  Attachment a = glue("drop", "");
  a.point = Vec3(0.3, 0.3, 0.3);  // its nearest particle, however far
  w.attach(a);
  run(w, 0.5);
  const double dt = w.options().time_step, sag = 9.81 * dt * dt / Links::kRigid;
  EXPECT_NEAR((place(w, 0, 0) - particle(0, 0, 0)).norm(), sag, 1e-3 * sag);
  EXPECT_LT(place(w, 1, 0).z(), -1.0);
  EXPECT_NEAR(w.step().links[0].force.z(), 9.81 * w.body(0).mass(), 1e-6);
}

TEST(LooseLinks, ADropHangsByTheParticlesOfARegionAndItsForceIsTheirWeight) {
  World w(options_at(0.05));
  w.add(drop("drop"));
  Attachment a = glue("drop", "");
  a.region = [](const Vec3&) { return true; };
  w.attach(a);
  run(w, 0.5);
  EXPECT_LT((place(w, 0, 63) - particle(3, 3, 3)).norm(), 1e-4);
  EXPECT_NEAR(w.step().links[0].force.z(), 9.81 * w.body(0).mass(), 1e-4 * 9.81 * w.body(0).mass());
}

TEST(LooseLinks, WhatHoldsParticlesKeepsMomentumToRounding) {
  for (const char* other : {"box", "jelly", "sheet", "rope", "springs", "fluid"})
    for (const bool region : {false, true})
      for (const double k : {0.0, 300.0}) {
        World w(floating());
        w.add(drop("drop"));
        const std::string kind = other;
        if (kind == "box")
          w.add(box("box", {Vec3(0.2, 0.2, 0.5), Quat::Identity(), Vec3(1, 0.3, 0), Vec3(0, 0, 2)}, 0.5, 0.2));
        if (kind == "jelly") w.add(testing::jelly("jelly", 0.4, Vec3(0, 0, 0.42)));
        if (kind == "sheet") w.add(testing::sheet("sheet", 0.6, Vec3(0.2, 0.2, 0.42)));
        if (kind == "rope") w.add(testing::rope("rope", Vec3(0, 0.16, 0.42), Vec3(0.8, 0.16, 0.42)));
        if (kind == "springs") w.add(testing::springs("springs", 0.4, Vec3(0, 0, 0.42)));
        if (kind == "fluid") w.add(drop("fluid", 4, Vec3(0, 0, 0.42)));
        w.set_touch({"*", "*", false});
        // It starts to move away and to turn.
        w.set_velocity(1, Vec3(0.1, 0.2, 0.3), Vec3(0, 0.5, 0));
        Attachment a = glue("drop", kind);
        a.stiffness = k, a.damping = k > 0.0 ? 5.0 : 0.0;
        if (region)
          a.region = [](const Vec3& x) { return x.z() > 0.3; };
        else
          a.point = particle(1, 1, 3);
        const std::string what = kind + (region ? ", a region" : ", a point") + (k > 0.0 ? ", springy" : ", rigid");
        ASSERT_NO_THROW(w.attach(a)) << what;
        const Momentum start = momentum(w);
        for (int s = 0; s < 20; ++s) {
          const StepReport r = w.step();
          ASSERT_TRUE(r.ok) << what;
          EXPECT_LT(r.momentum_error, 1e-12) << what;
          EXPECT_LT(r.angular_error, 1e-12) << what;
          EXPECT_GT(r.links[0].force.norm(), 0.0) << what;
          EXPECT_LT(r.links[0].error, 0.1) << what;
        }
        EXPECT_LT((momentum(w).linear - start.linear).norm(), kSolve * start.linear.norm()) << what;
      }
}

TEST(LooseLinks, JointsOfParticlesKeepMomentumToRoundingAndHoldTheirPlace) {
  for (const JointKind kind : {JointKind::Fixed, JointKind::Revolute, JointKind::Prismatic, JointKind::Ball})
    for (const bool fluid_is_child : {true, false}) {
      World w(floating());
      w.add(drop("drop"));
      w.add(box("box", {Vec3(0.2, 0.2, 0.2), Quat::Identity(), Vec3(0.2, 0.1, 0), Vec3(0, 0.5, 0.5)}, 0.5, 0.2));
      w.set_touch({"*", "*", false});
      Attachment a = fluid_is_child ? glue("drop", "box") : glue("box", "drop");
      a.joint.emplace();
      a.joint->kind = kind, a.joint->position = Vec3(0.2, 0.2, 0.2), a.joint->axis = Vec3(0, 1, 0);
      if (kind == JointKind::Revolute || kind == JointKind::Prismatic) {
        a.joint->damping = 0.1;
        a.joint->drive.damping = 1.0, a.joint->drive.target_velocity = 0.5;
      }
      w.attach(a);
      const Momentum start = momentum(w);
      for (int s = 0; s < 30; ++s) {
        const StepReport r = w.step();
        ASSERT_TRUE(r.ok);
        EXPECT_LT(r.momentum_error, 1e-12) << int(kind);
        EXPECT_LT(r.angular_error, 1e-12) << int(kind);
        EXPECT_LT(r.links[0].error, 0.01) << int(kind);
      }
      EXPECT_LT((momentum(w).linear - start.linear).norm(), kSolve * start.linear.norm());
    }
}

TEST(LooseLinks, AMotorOfAJointTurnsWhatItHolds) {
  World w(floating());
  w.add(drop("drop"));
  Attachment a = glue("drop", "");
  a.joint.emplace();
  a.joint->kind = JointKind::Revolute, a.joint->position = Vec3(0.2, 0.2, 0.2);
  a.joint->drive.damping = 50.0, a.joint->drive.target_velocity = 2.0;
  w.attach(a);
  double coordinate = 0.0;
  for (int s = 0; s < 30; ++s) coordinate = w.step().links[0].coordinate;
  EXPECT_NEAR(coordinate, 1.0, 0.05) << "2 rad/s over half a second";
}

TEST(LooseLinks, TwoFluidsHaveNoJointAndAreToldSo) {
  World w(floating());
  w.add(drop("drop"));
  w.add(drop("other", 4, Vec3(0, 0, 0.42)));
  Attachment a = glue("drop", "other");
  a.joint.emplace();
  a.joint->position = Vec3(0.2, 0.2, 0.4);
  try {
    w.attach(a);
    ADD_FAILURE() << "no place is of both";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("rods between two particles"), std::string::npos) << e.what();
  }
}

TEST(LooseLinks, OneBreaksAndGoesOnBrokenWhereTheRunIsTakenUp) {
  const auto make = [] {
    auto w = std::make_unique<World>(options_at(0.05));
    w->add(drop("drop", 2));
    Attachment a = glue("drop", "");
    a.region = [](const Vec3&) { return true; };
    a.break_force = 0.9 * 9.81 * w->body(0).mass();
    w->attach(a);
    return w;
  };
  auto w = make();
  bool said = false;
  for (int s = 0; s < 20; ++s)
    for (const Warning& warning : w->step().warnings) said = said || warning.code == "link_broken";
  EXPECT_TRUE(said);
  EXPECT_TRUE(w->step().links[0].broken);
  auto again = make();
  again->set_state(w->state());
  EXPECT_TRUE(again->step().links[0].broken);
  w->step();
  EXPECT_EQ(w->state().q, again->state().q);
}

TEST(LooseLinks, AnyNumberOfThreadsGivesTheSameBits) {
  const auto result = [](int threads) {
    const ThreadLimit limit(threads);
    World w(options_at(0.05));
    w.add(drop("drop", 6));
    w.add(testing::sheet("sheet", 0.8, Vec3(0.3, 0.3, -0.1)));
    Attachment a = glue("drop", "sheet");
    a.region = [](const Vec3& x) { return x.z() < 0.1; };
    a.touch = true;
    w.attach(a);
    run(w, 0.2);
    return w.state().q;
  };
  EXPECT_EQ(result(1), result(2));
}

}  // namespace
}  // namespace brim::loose_links_test
