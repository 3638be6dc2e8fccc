#include <fmt/format.h>
#include <gtest/gtest.h>

#include "brim/core/error.h"
#include "brim/world/attachment.h"
#include "brim/world/links.h"
#include "support/joints.h"
#include "support/soft_worlds.h"

/// Laws of joints between bodies (LinkJoint).
namespace brim::link_joints_test {
namespace {

using testing::box;
using testing::joint;
using testing::options_at;
using testing::position;
using testing::run;
using testing::spin;
using testing::velocity;

constexpr double kGravity = 9.81;

WorldOptions floating(double time_step = 1.0 / 120.0) {
  WorldOptions o = options_at(0.125);
  o.environment.gravity = Vec3::Zero();
  o.time_step = time_step;
  return o;
}

Quat rotation(const World& w, int b) { return Quat(w.q(b)[3], w.q(b)[4], w.q(b)[5], w.q(b)[6]); }

TEST(LinkJoints, ADoorOnItsHingeSwingsWithThePeriodOfACompoundPendulum) {
  WorldOptions o = options_at(0.125);
  o.time_step = 1.0 / 240.0;
  World w(o);
  const double angle = 0.1, l = 1.0;
  w.add(box("door", {l * Vec3(std::sin(angle), 0, -std::cos(angle)), rotation_from_vector(Vec3(0, -angle, 0))}));
  w.attach(joint(JointKind::Revolute, "door", "", Vec3::Zero(), Vec3(0, 1, 0)));
  const double period = 2.0 * std::numbers::pi * std::sqrt((l * l + 1.0 / 6.0) / (kGravity * l));
  std::vector<double> crossings;
  double swing = 0.0;
  while (w.state().time < 1.2 * period) {
    const double before = position(w, 0).x(), t = w.state().time;
    const StepReport r = w.step();
    swing = std::max(swing, std::abs(r.links[0].coordinate));
    EXPECT_LT(r.links[0].error, 1e-4);
    const double now = position(w, 0).x();
    if ((before < 0.0) != (now < 0.0)) crossings.push_back(t + o.time_step * before / (before - now));
  }
  ASSERT_GE(crossings.size(), 2u);
  EXPECT_NEAR(2.0 * (crossings[1] - crossings[0]), period, 0.01 * period);
  EXPECT_NEAR(swing, 2.0 * angle, 0.02);
  EXPECT_LT(std::abs(position(w, 0).y()), 1e-6);
}

TEST(LinkJoints, ADoorThatRestsOnItsLimitIsSetGoingByABlow) {
  // A weak spring holds a door against its limit; a ball strikes it at 0.35 m from the hinge and stays with it:
  // ω = m r v / (I + m r²). A limit that pulled back within the step took a half of that, and more in short steps.
  const double r = 0.35, v = 2.69, radius = 0.1, m = 700.0 * 4.0 / 3.0 * std::numbers::pi * 1e-3;
  const Vec3 size(0.05, 0.7, 0.4);
  const double mass = 200.0 * size.prod(), own = mass * (size.x() * size.x() + size.y() * size.y()) / 12.0;
  const double theory = m * r * v / (own + mass * r * r + m * r * r);
  for (const JointKind kind : {JointKind::Revolute, JointKind::Prismatic})
    for (const int substeps : {1, 8}) {
      WorldOptions o = floating();
      o.voxel_size = 0.025, o.response = Response::Constraint, o.min_substeps = substeps;
      World w(o);
      RigidModel door;
      door.shape = make_box(size), door.mass = mass;
      door.inertia = (mass / 12.0 *
                      Vec3(size.y() * size.y() + size.z() * size.z(), size.x() * size.x() + size.z() * size.z(),
                           size.x() * size.x() + size.y() * size.y()))
                         .asDiagonal();
      door.part.material.friction = 0.0;
      auto body = std::make_unique<RigidBody>(door);
      body->set_name("door");
      w.add(std::move(body));
      w.add(testing::ball("ball", {Vec3(-0.4, 0, 0), Quat::Identity(), Vec3(v, 0, 0)}, 0.0, radius, 700.0));
      const bool turns = kind == JointKind::Revolute;
      Attachment a = joint(kind, "door", "", Vec3(0, r, 0), turns ? Vec3(0, 0, 1) : Vec3(1, 0, 0));
      a.joint->lower = 0.0;
      a.joint->drive.stiffness = 1.0, a.joint->drive.target = -0.1;
      w.attach(a);
      double most = 0.0;
      const double start = 0.5 * m * v * v;
      for (int s = 0; s < 40; ++s) {
        EXPECT_LT(w.step().kinetic_energy, 1.001 * start);
        most = std::max(most, turns ? std::abs(spin(w, 0).z()) : velocity(w, 0).x());
      }
      EXPECT_NEAR(most, turns ? theory : m * v / (m + mass), 0.03 * (turns ? theory : v))
          << (turns ? "hinge" : "slide") << ", sub-steps " << substeps;
    }
}

TEST(LinkJoints, TwoBoxesThatAreFixedMoveAsOneAndKeepTheirMomentum) {
  World w(floating());
  w.add(box("a", {Vec3(0, 0, 0), Quat::Identity(), Vec3(1, 0, 0), Vec3(0, 0, 1)}));
  w.add(box("b", {Vec3(1.2, 0, 0), Quat::Identity(), Vec3(0, 0.4, 0.2)}));
  w.attach(joint(JointKind::Fixed, "a", "b", Vec3(0.6, 0, 0)));
  const auto momentum = [&](auto f) { return Vec3(f(0) + f(1)); };
  const auto linear = [&](int b) { return w.body(b).linear_momentum(w.v(b)); };
  const auto angular = [&](int b) { return w.body(b).angular_momentum(w.v(b)); };
  const Vec3 p = momentum(linear), L = momentum(angular);
  for (int s = 0; s < 120; ++s) {
    const StepReport r = w.step();
    EXPECT_LT(r.momentum_error, 1e-12);
    EXPECT_LT(r.angular_error, 1e-12);
  }
  EXPECT_LT((momentum(linear) - p).norm(), 1e-9 * p.norm());   // what the solve leaves
  EXPECT_LT((momentum(angular) - L).norm(), 2e-3 * L.norm());  // positions move after velocities
  const Vec3 between = rotation(w, 0).conjugate() * (position(w, 1) - position(w, 0));
  EXPECT_LT((between - Vec3(1.2, 0, 0)).norm(), 1e-3);
  EXPECT_LT(rotation(w, 0).angularDistance(rotation(w, 1)), 1e-3);
}

TEST(LinkJoints, ASlideLetsGoAlongItsAxisAndHoldsAcrossIt) {
  World w(options_at(0.125));
  w.add(box("box", {Vec3(0, 0, 0)}));
  const Vec3 axis = Vec3(1, 0, -1).normalized();
  w.attach(joint(JointKind::Prismatic, "box", "", Vec3(0.2, 0.1, 0), axis));
  run(w, 1.0);
  // Positions move by the velocities at the end of each of the 60 steps.
  const double way = 0.5 * kGravity * std::sqrt(0.5) * (1.0 + 1.0 / 60.0);
  EXPECT_NEAR(position(w, 0).dot(axis), way, 1e-3 * way);
  EXPECT_LT((position(w, 0) - axis * axis.dot(position(w, 0))).norm(), 1e-4);
  EXPECT_LT(rotation(w, 0).angularDistance(Quat::Identity()), 1e-4);
  EXPECT_NEAR(w.step().links[0].coordinate, position(w, 0).dot(axis), 0.15);
}

TEST(LinkJoints, AMotorReachesItsVelocityAndItsReactionActsOnTheOther) {
  World w(floating());
  w.add(box("rotor", {Vec3(0, 0, 0)}));
  w.add(box("stator", {Vec3(0, 0, 1.2)}));
  Attachment a = joint(JointKind::Revolute, "rotor", "stator", Vec3(0, 0, 0.6));
  a.joint->drive.damping = 1e4, a.joint->drive.target_velocity = 3.0;
  w.attach(a);
  run(w, 0.5);
  EXPECT_NEAR(spin(w, 0).z() - spin(w, 1).z(), 3.0, 1e-3);
  EXPECT_NEAR(spin(w, 0).z() + spin(w, 1).z(), 0.0, 1e-9);
  w.set_drive(0, 0.0, -1.0);
  run(w, 0.5);
  EXPECT_NEAR(spin(w, 0).z() - spin(w, 1).z(), -1.0, 1e-3);
}

TEST(LinkJoints, APositionDriveGoesWhereItIsToldWithNoMoreThanItsForce) {
  World w(floating());
  w.add(box("arm", {Vec3(0, 0, 0)}));
  Attachment a = joint(JointKind::Revolute, "arm", "", Vec3(0, 0, 0));
  a.joint->drive.stiffness = 5e3, a.joint->drive.damping = 1500.0, a.joint->drive.target = 1.0;
  a.joint->drive.force_limit = 200.0;
  w.attach(a);
  double most = 0.0;
  StepReport r;
  for (int s = 0; s < 600; ++s) {
    r = w.step();
    most = std::max(most, std::abs(r.links[0].effort));
  }
  EXPECT_LT(most, 250.0);  // the limit holds for the start of a step, as in articulated bodies
  EXPECT_GT(most, 150.0);
  EXPECT_NEAR(r.links[0].coordinate, 1.0, 1e-3);
  EXPECT_NEAR(2.0 * std::atan2(rotation(w, 0).z(), rotation(w, 0).w()), 1.0, 1e-3);
}

TEST(LinkJoints, ALimitStopsATurnAndASlide) {
  {
    World w(options_at(0.125));
    w.add(box("door", {Vec3(1, 0, 0)}));
    Attachment a = joint(JointKind::Revolute, "door", "", Vec3::Zero(), Vec3(0, 1, 0));
    a.joint->upper = 0.4, a.joint->lower = -0.2, a.joint->damping = 2000.0;
    w.attach(a);
    run(w, 4.0);
    const StepReport r = w.step();
    EXPECT_NEAR(r.links[0].coordinate, 0.4, 1e-3);
    EXPECT_NEAR(r.links[0].effort, -1000.0 * kGravity * std::cos(0.4), 50.0);
  }
  World w(options_at(0.125));
  w.add(box("box", {Vec3(0, 0, 0)}));
  Attachment a = joint(JointKind::Prismatic, "box", "", Vec3::Zero());
  a.joint->lower = -0.5;
  w.attach(a);
  run(w, 1.0);
  EXPECT_NEAR(position(w, 0).z(), -0.5, 1e-3);
}

TEST(LinkJoints, ALimitTakesTheMotionAndGivesNone) {
  for (const double dt : {1.0 / 60.0, 1.0 / 240.0})
    for (const double arm : {0.0, 1.0}) {
      World w(floating(dt));
      w.add(box("door", {Vec3(arm, 0, 0), Quat::Identity(), Vec3(0, arm, 0), Vec3(0, 0, 1)}));
      Attachment a = joint(JointKind::Revolute, "door", "", Vec3::Zero());
      a.joint->upper = 0.5;
      w.attach(a);
      run(w, 1.0);
      EXPECT_NEAR(w.v(0)[5], 0.0, 0.01) << "arm " << arm << ", dt " << dt << ": it left at half its speed";
      EXPECT_NEAR(w.step().links[0].coordinate, 0.5, 0.01);
    }
}

TEST(LinkJoints, AHingeBesideTheMiddleTurnsAsItsDriveAndDampingSay) {
  // What closes the error at the axis is no turning.
  for (const double dt : {1.0 / 60.0, 1.0 / 240.0}) {
    World driven(floating(dt)), damped(floating(dt));
    const double inertia = 1000.0 * (1.0 + 1.0 / 6.0);
    driven.add(box("door", {Vec3(1, 0, 0)}));
    damped.add(box("door", {Vec3(1, 0, 0), Quat::Identity(), Vec3(0, 3, 0), Vec3(0, 0, 3)}));
    Attachment a = joint(JointKind::Revolute, "door", "", Vec3::Zero());
    a.joint->drive.damping = 1e4, a.joint->drive.target_velocity = 3.0;
    driven.attach(a);
    a.joint->drive = {}, a.joint->damping = 500.0;
    damped.attach(a);
    run(driven, 2.0), run(damped, 2.0);
    EXPECT_NEAR(driven.v(0)[5], 3.0, 0.01) << "1.85 for 3 rad/s";
    EXPECT_NEAR(damped.v(0)[5], 3.0 * std::exp(-500.0 * 2.0 / inertia), 0.01);
  }
}

TEST(LinkJoints, AWeldedBeamIsStraight) {
  World w(options_at(0.125));
  const int n = 8;
  for (int i = 0; i < n; ++i) {
    w.add(box("box" + std::to_string(i), {Vec3(0.5 * i, 0, 2)}, 0.5, 0.5));
    Attachment a = joint(JointKind::Fixed, "box" + std::to_string(i), i > 0 ? "box" + std::to_string(i - 1) : "",
                         Vec3(0.5 * i - 0.25, 0, 2));
    a.name += std::to_string(i);
    w.attach(a);
  }
  run(w, 2.0);
  EXPECT_GT(position(w, n - 1).z(), 1.97) << "of 4 m; links as far apart as a quarter of a box hung like a rope";
}

/// What a hinge carries is the weight, whether the body lies on a limit, is held by a drive or by nothing along it; the
/// points around the axis carry far more, of a couple with what acts along the coordinate.
TEST(LinkJoints, TheForceOfAJointAtALimitOrUnderADriveIsWhatTheBodyNeeds) {
  const double weight = 1000.0 * kGravity;
  const auto settle = [&](JointKind kind, bool driven, double break_force) {
    World w(options_at(0.125));
    w.add(box("door", {Vec3(1, 0, 0)}));
    Attachment a = joint(kind, "door", "", Vec3::Zero(), kind == JointKind::Revolute ? Vec3(0, 1, 0) : Vec3(0, 0, 1));
    a.joint->damping = 2000.0, a.break_force = break_force;
    if (driven)
      a.joint->drive.stiffness = 1e6, a.joint->drive.damping = 1e4;
    else
      a.joint->upper = 0.4, a.joint->lower = -0.4;
    w.attach(a);
    StepReport r;
    for (int s = 0; s < 300; ++s) r = w.step();
    return r.links[0];
  };
  for (const JointKind kind : {JointKind::Revolute, JointKind::Prismatic})
    for (const bool driven : {false, true}) {
      SCOPED_TRACE(driven);
      const LinkReport r = settle(kind, driven, std::numeric_limits<double>::infinity());
      EXPECT_LT((r.force - Vec3(0, 0, weight)).norm(), 0.01 * weight) << r.force.transpose();
      EXPECT_TRUE(settle(kind, driven, 0.9 * weight).broken);
    }
  EXPECT_FALSE(settle(JointKind::Revolute, true, 3.0 * weight).broken) << "twice what it needs as it is let go";
}

TEST(LinkJoints, ASoftBodyHangsOnAHingeOfARigidOne) {
  WorldOptions o = options_at(0.1);
  World w(o);
  w.add(testing::jelly("jelly", 0.6, Vec3(0, 0, 1)));
  w.add(testing::obstacle("wall", make_box(Vec3(0.2, 2, 2)), 0.5, Vec3(-0.2, 0.3, 1.3)));
  Attachment a = joint(JointKind::Revolute, "jelly", "wall", Vec3(0.05, 0.3, 1.5), Vec3(0, 1, 0));
  a.joint->span = 0.2;
  w.attach(a);
  StepReport r;
  for (int s = 0; s < 120; ++s) {
    r = w.step();
    ASSERT_TRUE(r.ok);
    EXPECT_LT(r.links[0].error, 1e-3);
    EXPECT_LT(r.momentum_error, 1e-9);
  }
  EXPECT_GT(r.links[0].coordinate, 0.3);  // it swings down
}

TEST(LinkJoints, SidesOfNodesAreHeldWhereTheyAreNearestToEachOther) {
  // A rope just above a sheet, and a jelly that a sheet cuts: neither side carries points that it has no matter at.
  for (const JointKind kind : {JointKind::Ball, JointKind::Fixed, JointKind::Revolute, JointKind::Prismatic})
    for (const std::string other : {"rope", "jelly"}) {
      SCOPED_TRACE(fmt::format("{} to {}", static_cast<int>(kind), other));
      WorldOptions o = floating();
      o.voxel_size = 0.05;
      World w(o);
      w.add(testing::sheet("sheet", 1.0, Vec3(0.0, 0.0, 0.0)));
      if (other == "rope")
        w.add(testing::rope("rope", Vec3(-0.5, 0.0, 0.04), Vec3(0.5, 0.0, 0.04)));
      else
        w.add(testing::jelly("jelly", 0.4, Vec3(-0.2, -0.2, -0.1)));
      w.attach(joint(kind, other, "sheet", Vec3(0.02, 0.01, 0.03), Vec3(1, 0, 0)));
      StepReport r;
      for (int s = 0; s < 90; ++s) {
        r = w.step();
        ASSERT_TRUE(r.ok);
        EXPECT_LT(r.momentum_error, 1e-9);
      }
      EXPECT_LT(r.links[0].error, 0.1 * w.options().voxel_size);
      double fastest = 0.0;
      for (int b = 0; b < 2; ++b)
        for (std::size_t i = 0; i < w.v(b).size(); ++i) fastest = std::max(fastest, std::abs(w.v(b)[i]));
      EXPECT_LT(fastest, 1.0);  // drawn together gently
    }
}

TEST(LinkJoints, WhatCannotBeIsRefused) {
  World w(floating());
  w.add(box("box", {Vec3(0, 0, 0)}));
  Attachment a = joint(JointKind::Ball, "box", "", Vec3::Zero());
  a.joint->upper = 1.0;
  EXPECT_THROW(w.attach(a), InputError);
  a = joint(JointKind::Revolute, "box", "", Vec3::Zero(), Vec3::Zero());
  EXPECT_THROW(w.attach(a), InputError);
  a = joint(JointKind::Revolute, "box", "", Vec3::Zero());
  a.point = Vec3::Zero();
  EXPECT_THROW(w.attach(a), InputError);
  a.point.reset();
  w.attach(a);
  EXPECT_THROW(w.set_drive(0, 1.0, 0.0), InputError);

  World far(floating());
  far.add(testing::sheet("sheet", 1.0, Vec3::Zero()));
  far.add(testing::jelly("jelly", 0.6, Vec3(0, 0, 2)));
  EXPECT_THROW(far.attach(joint(JointKind::Ball, "jelly", "sheet", Vec3(0, 0, 1))), InputError);
}

TEST(LinkJoints, DrivesAndLimitsReportTheEnergyOfTheirSprings) {
  constexpr double kStiffness = 200.0, kLimit = 50.0;
  const auto potential = [](double target, double force_limit, double upper) {
    World w(floating(1e-4));
    w.add(box("sled", {}));
    Attachment slide = joint(JointKind::Prismatic, "sled", "", Vec3::Zero(), Vec3(1, 0, 0));
    slide.joint->drive.stiffness = kStiffness, slide.joint->drive.target = target;
    slide.joint->drive.force_limit = force_limit;
    slide.joint->upper = upper, slide.joint->limit_stiffness = 3e3;
    w.attach(slide);
    return w.step().potential_energy;
  };
  const double free = std::numeric_limits<double>::infinity(), close = 1e-4 * 0.5 * kStiffness;
  EXPECT_NEAR(potential(1.0, free, free), 0.5 * kStiffness, close);
  // With a limited force F the work of going there: F (miss − F / 2k).
  EXPECT_NEAR(potential(1.0, kLimit, free), kLimit * (1.0 - 0.5 * kLimit / kStiffness), close);
  EXPECT_NEAR(potential(0.0, free, -0.1), 0.5 * 3e3 * 0.01, close);
}

}  // namespace
}  // namespace brim::link_joints_test
