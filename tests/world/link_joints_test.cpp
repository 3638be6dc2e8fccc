#include <fmt/format.h>
#include <gtest/gtest.h>

#include "brim/core/error.h"
#include "brim/world/attachment.h"
#include "brim/world/links.h"
#include "support/soft_worlds.h"

/// Laws of joints between bodies (LinkJoint).
namespace brim::link_joints_test {
namespace {

using testing::box;
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

Attachment joint(JointKind kind, std::string body, std::string to, const Vec3& x, const Vec3& axis = Vec3(0, 0, 1)) {
  Attachment a;
  a.name = "joint", a.body = std::move(body), a.to = std::move(to);
  a.touch = false;
  a.joint.emplace();
  a.joint->kind = kind, a.joint->position = x, a.joint->axis = axis;
  return a;
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

TEST(LinkJoints, LightSolidsCarryHeavyOnesWithoutSwinging) {
  for (const int most : {64, 1}) {
    WorldOptions o = options_at(0.05);
    o.max_substeps = most;
    World w(o);
    const int n = 8;
    bool told = false, capped = false;
    for (int i = 0; i <= n; ++i) {
      const std::string name = "box" + std::to_string(i);
      testing::Start start;
      start.x = Vec3(0, 0, 2.0 - 0.2 * i), start.v = Vec3(1e-3, 0, 0);
      w.add(box(name, start, 0.5, 0.1, i < n ? 1000.0 : 50e3));
      Attachment a =
          joint(JointKind::Ball, name, i > 0 ? "box" + std::to_string(i - 1) : "", Vec3(0, 0, 2.1 - 0.2 * i));
      a.name += std::to_string(i);
      w.attach(a);
    }
    double energy = 0.0;
    for (int s = 0; s < 240; ++s) {
      const StepReport r = w.step();
      energy = r.kinetic_energy;
      for (const Warning& warning : r.warnings) {
        told |= warning.code == "link_apart";
        capped |= warning.code == "substeps_capped" && warning.message.find("pull hard") != std::string::npos;
      }
    }
    EXPECT_EQ(capped, most == 1);
    EXPECT_EQ(energy<0.1, most> 1) << energy;
    EXPECT_EQ(told, most == 1) << "one sub-step is too long, and is told to be";
  }
}

/// A chain of n links of 0.2 kg with a weight of 50 kg, which moves at 2 m/s.
World light_chain(int n) {
  WorldOptions o = options_at(0.0075);
  o.response = Response::Constraint;
  World w(o);
  const double length = 0.16;
  for (int i = 0; i <= n; ++i) {
    const bool weight = i == n;
    RigidModel m;
    m.shape = weight ? make_sphere(0.2) : make_capsule(0.03, 0.1);
    m.mass = weight ? 50.0 : 0.2;
    m.inertia = weight ? Vec3(0.8, 0.8, 0.8).asDiagonal() : Vec3(4.7e-4, 4.7e-4, 9e-5).asDiagonal();
    m.position = Vec3(0, 0, -length * i - (weight ? 0.2 : 0.5 * length));
    auto link = std::make_unique<RigidBody>(m);
    link->set_name("link" + std::to_string(i));
    w.add(std::move(link));
    Attachment a = joint(JointKind::Ball, "link" + std::to_string(i), i > 0 ? "link" + std::to_string(i - 1) : "",
                         Vec3(0, 0, -length * i));
    a.name += std::to_string(i);
    w.attach(a);
  }
  w.set_velocity(n, Vec3(2, 0, 0), Vec3::Zero());
  return w;
}

/// The pull of a swinging chain rises and falls within a step. Sub-steps that became longer and shorter with it fed the
/// swing of its light links: 20 of them gained 815 J.
TEST(LinkJoints, ALightChainWithAHeavyEndGainsNoEnergy) {
  for (const int n : {10, 20}) {
    World w = light_chain(n);
    const StepReport start = w.present();
    double most = -std::numeric_limits<double>::infinity(), least = 0.0;
    for (int s = 0; s < 300; ++s) {
      const StepReport r = w.step();
      const double gained = r.kinetic_energy + r.potential_energy - start.kinetic_energy - start.potential_energy;
      most = std::max(most, gained), least = std::min(least, gained);
    }
    EXPECT_LT(most, 0.0) << n << " links; the weight has 100 J";
    EXPECT_GT(least, -5.0) << n << " links";
  }
}

TEST(LinkJoints, SubstepsOfASwingingChainAreTheSameFromItsState) {
  World w = light_chain(10);
  run(w, 1.0);
  const State state = w.state();
  World other = light_chain(10);
  other.set_state(state);
  for (int s = 0; s < 30; ++s) ASSERT_EQ(w.step().substeps, other.step().substeps) << "step " << s;
  EXPECT_EQ(w.state().q, other.state().q);
}

TEST(LinkJoints, SubstepsAreLongAgainOnceAllLinksAreGone) {
  World w = light_chain(10);
  w.set_velocity(10, Vec3::Zero(), Vec3::Zero());
  run(w, 0.2);
  EXPECT_GT(w.step().substeps, 2);
  for (int i = 0; i <= 10; ++i) w.detach(i);
  w.step();
  EXPECT_EQ(w.step().substeps, 1);
}

/// A bridge of planks between two fixed hinges, straight at first: nothing holds it across until it has sagged, and
/// then its pull is large. What the fall stretched comes back as speed where shorter sub-steps close it.
TEST(LinkJoints, AStraightBridgeSagsAndGainsNoEnergy) {
  for (const int n : {5, 7, 9}) {
    World w(options_at(0.025));
    const auto x_of = [&](int i) { return 0.3 * (i - 0.5 * n); };
    for (int i = 0; i < n; ++i) {
      RigidModel m;
      m.shape = make_box(Vec3(0.25, 1.0, 0.05));
      m.mass = 5.0;
      m.inertia = m.mass / 12.0 * Vec3(1.0025, 0.065, 1.0625).asDiagonal();
      m.position = Vec3(x_of(i) + 0.15, 0, 0);
      auto plank = std::make_unique<RigidBody>(m);
      plank->set_name("plank" + std::to_string(i));
      w.add(std::move(plank));
    }
    for (int i = 0; i <= n; ++i) {
      const std::string name = "plank" + std::to_string(std::min(i, n - 1));
      Attachment a = joint(JointKind::Revolute, name, i > 0 && i < n ? "plank" + std::to_string(i - 1) : "",
                           Vec3(x_of(i), 0, 0), Vec3(0, 1, 0));
      a.name += std::to_string(i);
      w.attach(a);
    }
    double most = -std::numeric_limits<double>::infinity(), apart = 0.0;
    StepReport r;
    for (int s = 0; s < 120; ++s) {
      r = w.step();
      ASSERT_TRUE(r.ok) << n << " planks";
      most = std::max(most, r.kinetic_energy + r.potential_energy);
      for (const LinkReport& link : r.links) apart = std::max(apart, link.error);
    }
    EXPECT_LT(most, 0.01) << n << " planks; the start has 0 J";
    EXPECT_LT(apart, 0.01) << n << " planks";
  }
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

/// A bob, or a body of any inertia, on a joint at the origin, which is beside its middle.
RigidModel on_joint(const Vec3& middle, const Vec3& inertia, const Vec3& velocity, const Vec3& spin) {
  RigidModel m;
  m.shape = make_sphere(0.05);
  m.mass = 1.0;
  m.inertia = inertia.asDiagonal();
  m.position = middle, m.velocity = velocity, m.angular_velocity = spin;
  return m;
}

double energy(const StepReport& r) { return r.kinetic_energy + r.potential_energy; }

/// Sub-steps of a swing are shorter where it is fast. Gravity over the new length alone took a part of the energy at
/// every change: 1.4 J of a bob's 2.5 in 20 s.
TEST(LinkJoints, ABobSwingsAsHighAfterManySubstepsOfTwoLengths) {
  WorldOptions o = options_at(0.02);
  o.time_step = 1.0 / 60.0;
  World w(o);
  w.add(std::make_unique<RigidBody>(
      on_joint(Vec3(std::sqrt(0.75), 0, -0.5), Vec3::Constant(1e-3), Vec3::Zero(), Vec3::Zero())));
  Attachment pivot = joint(JointKind::Revolute, w.body(0).name(), "", Vec3::Zero(), Vec3(0, 1, 0));
  w.attach(pivot);
  const double start = energy(w.present());
  int least = 100, most = 0;
  for (int s = 0; s < 1200; ++s) {
    const StepReport r = w.step();
    least = std::min(least, r.substeps), most = std::max(most, r.substeps);
    ASSERT_NEAR(energy(r), start, 0.15) << "step " << s;
  }
  EXPECT_LT(least, most);  // what this test is about
}

/// Two bars of 1 m and 1 kg, released level: the tips reach 7 m/s. Joints whose ends move straight within a sub-step
/// lost 4.3 J in 10 s at 1/60 s.
TEST(LinkJoints, ADoublePendulumKeepsItsEnergyInOneSubstep) {
  WorldOptions o = options_at(0.025);
  o.time_step = 1.0 / 60.0;
  World w(o);
  for (int i = 0; i < 2; ++i) {
    RigidModel m;
    m.shape = make_box(Vec3(0.9, 0.05, 0.05));
    m.mass = 1.0, m.inertia = Vec3(4.2e-4, 0.0677, 0.0677).asDiagonal();
    m.position = Vec3(0.5 + i, 0, 0);
    auto bar = std::make_unique<RigidBody>(m);
    bar->set_name("bar" + std::to_string(i));
    w.add(std::move(bar));
    Attachment a =
        joint(JointKind::Revolute, "bar" + std::to_string(i), i > 0 ? "bar0" : "", Vec3(i, 0, 0), Vec3(0, 1, 0));
    a.name += std::to_string(i);
    w.attach(a);
  }
  const double start = energy(w.present());
  for (int s = 0; s < 600; ++s) {
    const StepReport r = w.step();
    ASSERT_EQ(r.substeps, 1);
    ASSERT_NEAR(energy(r), start, 0.8) << "step " << s;  // the second bar falls by up to 20 J
    for (const LinkReport& l : r.links) ASSERT_LT(l.error, 2e-3);
  }
}

/// A gyroscope of 56 J on a joint beside it: more than a radian in a sub-step would be more than a solve can follow.
TEST(LinkJoints, AGyroscopeOnAJointKeepsItsEnergy) {
  for (const double spin : {20.0, 50.0, 150.0}) {
    WorldOptions o = options_at(0.02);
    o.time_step = 1.0 / 60.0;
    World w(o);
    const double l = 0.15, turn = kGravity * l / (5e-3 * spin);  // [rad/s] of precession
    w.add(std::make_unique<RigidBody>(
        on_joint(Vec3(l, 0, 0), Vec3(5e-3, 2.5e-3, 2.5e-3), Vec3(0, l * turn, 0), Vec3(spin, 0, turn))));
    w.attach(joint(JointKind::Ball, w.body(0).name(), "", Vec3::Zero()));
    const double start = energy(w.present());
    for (int s = 0; s < 240; ++s) {
      const StepReport r = w.step();
      ASSERT_GE(r.substeps, spin * r.dt / Links::kSpin - 1e-6);
      ASSERT_NEAR(energy(r), start, 0.15) << spin << " rad/s, step " << s;
    }
  }
}

TEST(LinkJoints, ASpinThatNeedsMoreSubstepsThanAllowedIsToldOf) {
  WorldOptions o = options_at(0.02);
  o.time_step = 1.0 / 60.0, o.max_substeps = 2;
  World w(o);
  w.add(std::make_unique<RigidBody>(
      on_joint(Vec3(0.15, 0, 0), Vec3(5e-3, 2.5e-3, 2.5e-3), Vec3::Zero(), Vec3(150, 0, 0))));
  w.attach(joint(JointKind::Ball, w.body(0).name(), "", Vec3::Zero()));
  const StepReport r = w.step();
  ASSERT_FALSE(r.warnings.empty());
  EXPECT_EQ(r.warnings[0].code, "substeps_capped");
  EXPECT_NE(r.warnings[0].message.find("spin by more than 1 rad in each of the 2 sub-steps"), std::string::npos)
      << r.warnings[0].message;
}

/// What rests on something presses on it by its weight, whatever the lengths of sub-steps: gravity over the mean of two
/// lengths would be more or less.
TEST(LinkJoints, AWeightOnAFloorPressesByItsWeightWhenSubstepsChange) {
  WorldOptions o = options_at(0.05);
  o.time_step = 1.0 / 60.0, o.response = Response::Penalty;
  World w(o);
  w.add(testing::ground(0.5));
  w.add(box("weight", {Vec3(0, 0, 0.5), Quat::Identity()}));
  Attachment slider = joint(JointKind::Prismatic, "weight", "", Vec3(0, 0, 0.5));
  w.attach(slider);
  RigidModel wheel;
  wheel.shape = make_sphere(0.1), wheel.mass = 1.0, wheel.inertia = 4e-3 * Mat3::Identity();
  wheel.position = Vec3(20, 0, 20);
  const int spun = w.add(std::make_unique<RigidBody>(wheel));
  Attachment axle = joint(JointKind::Revolute, w.body(spun).name(), "", wheel.position);
  axle.name = "axle";
  w.attach(axle);
  run(w, 0.5);
  for (const double turns : {0.0, 4.0, 0.0, 8.0, 0.0}) {
    w.set_velocity(spun, Vec3::Zero(), Vec3(0, 0, turns * 60.0));
    const StepReport r = w.step();
    EXPECT_GE(r.substeps, turns) << "what this test is about";
    ASSERT_EQ(r.pairs.size(), 1u);
    EXPECT_NEAR(r.pairs[0].force_on_a.norm(), 1000.0 * kGravity, 0.02 * 1000.0 * kGravity) << turns;
  }
}

}  // namespace
}  // namespace brim::link_joints_test
