#include <gtest/gtest.h>

#include "brim/body/articulated/articulated_body.h"
#include "brim/core/parallel.h"
#include "brim/world/attachment.h"
#include "support/worlds.h"

/// Links of articulated bodies on rows: what they do that rigid bodies do too, and the mechanics of trees.
namespace brim::links_on_rows_test {
namespace {

using testing::Start;

constexpr double kGravity = 9.81, kSlope = 15.0 / 180.0 * std::numbers::pi;
const Vec3 kNormal(std::sin(kSlope), 0.0, std::cos(kSlope)), kDown(std::cos(kSlope), 0.0, -std::sin(kSlope));

WorldOptions rows_at(double h) {
  WorldOptions o = testing::options_at(h);
  o.response = Response::Constraint;
  o.time_step = 1.0 / 120.0;
  return o;
}

WorldOptions weightless(double h) {
  WorldOptions o = rows_at(h);
  o.environment.gravity = Vec3::Zero();
  return o;
}

/// A solid of 1 kg, with its own inertia.
struct Solid {
  std::shared_ptr<const Shape> shape;
  Vec3 inertia;
  double friction = 0.5, restitution = 0.0;
};

Solid ball(double radius) { return {make_sphere(radius), Vec3::Constant(0.4 * radius * radius)}; }

Solid cylinder(double radius, double length) {
  const double across = radius * radius / 4.0 + length * length / 12.0;
  return {make_cylinder(radius, length), Vec3(across, across, radius * radius / 2.0)};
}

PartInfo part_of(const Solid& s) {
  PartInfo p;
  p.material.friction = s.friction, p.material.restitution = s.restitution;
  return p;
}

LinkModel link_of(const Solid& s, const Quat& turn = Quat::Identity()) {
  LinkModel l;
  l.mass = 1.0;
  l.inertia = turn.toRotationMatrix() * s.inertia.asDiagonal() * turn.toRotationMatrix().transpose();
  l.shapes.push_back({s.shape, {turn.toRotationMatrix(), Vec3::Zero()}, {}, part_of(s)});
  return l;
}

std::unique_ptr<Body> tree(const char* name, ArticulatedModel m) {
  auto b = std::make_unique<ArticulatedBody>(std::move(m));
  b->set_name(name);
  return b;
}

JointModel free_joint(const Start& s) {
  JointModel j;
  j.kind = JointKind::Free;
  j.position = s.x, j.rotation = s.rotation, j.velocity = s.v, j.angular_velocity = s.w;
  return j;
}

JointModel hinge(const Vec3& at, const Vec3& axis = Vec3(0, 1, 0)) {
  JointModel j;
  j.kind = JointKind::Revolute;
  j.position = at, j.axis = axis;
  return j;
}

/// A tree of one link.
std::unique_ptr<Body> lone_link(const Solid& s, const Start& start) {
  ArticulatedModel m;
  m.links.push_back(link_of(s));
  m.links[0].joint = free_joint(start);
  return tree("body", std::move(m));
}

std::unique_ptr<Body> rigid_body(const Solid& s, const Start& start) {
  RigidModel m;
  m.shape = s.shape;
  m.mass = 1.0, m.inertia = s.inertia.asDiagonal();
  m.position = start.x, m.rotation = start.rotation, m.velocity = start.v, m.angular_velocity = start.w;
  m.part = part_of(s);
  auto b = std::make_unique<RigidBody>(m);
  b->set_name("body");
  return b;
}

/// A chain of balls that hinges join, all of whose matter is theirs.
std::unique_ptr<Body> chain(const char* name, const Start& start, double radius = 0.2) {
  ArticulatedModel m;
  for (int i = 0; i < 3; ++i) {
    m.links.push_back(link_of(ball(radius)));
    m.links.back().parent = i - 1;
    m.links.back().joint = i == 0 ? free_joint(start) : hinge(Vec3(2.2 * radius, 0, 0), Vec3(0, 1, 0.3 * i));
  }
  return tree(name, std::move(m));
}

/// A slab on four cylinders that hinges carry.
std::unique_ptr<Body> cart(double radius, const Start& start) {
  ArticulatedModel m;
  Solid slab{make_box(Vec3(1.0, 0.4, 0.1)), Vec3(0.14, 0.84, 0.97)};
  m.links.push_back(link_of(slab));
  m.links[0].mass = 10.0;
  m.links[0].joint = free_joint(start);
  for (const double x : {-0.4, 0.4})
    for (const double y : {-0.3, 0.3}) {
      m.links.push_back(link_of(cylinder(radius, 0.08), Quat::FromTwoVectors(Vec3::UnitZ(), Vec3::UnitY())));
      m.links.back().parent = 0;
      m.links.back().joint = hinge(Vec3(x, y, 0));
    }
  return tree("cart", std::move(m));
}

TEST(LinksOnRows, RollDownASlopeAsTheirInertiaSays) {
  constexpr double R = 0.5;
  for (const double h : {R / 4.0, R / 8.0})
    for (const bool is_ball : {true, false}) {
      SCOPED_TRACE(std::string(is_ball ? "ball" : "cylinder") + ", h = " + std::to_string(h));
      const Solid s = is_ball ? ball(R) : cylinder(R, 1.0);
      const Start start{R * kNormal + 0.013 * kDown + Vec3(0, 0.02, 0),
                        Quat::FromTwoVectors(Vec3::UnitZ(), Vec3::UnitY())};
      World w(rows_at(h));
      w.add(testing::ground(0.5, kNormal));
      const int b = w.add(lone_link(s, start));
      testing::run(w, 2.0);
      const double v = kGravity * std::sin(kSlope) / (is_ball ? 1.4 : 1.5) * 2.0;
      EXPECT_NEAR(testing::velocity(w, b).dot(kDown), v, 1e-4 * v);
      EXPECT_NEAR(testing::spin(w, b).norm() * R, v, 1e-4 * v);
    }
}

TEST(LinksOnRows, ACartRollsAsItsWheelsSay) {
  for (const double h : {0.0375, 0.01875}) {
    SCOPED_TRACE(h);
    World w(rows_at(h));
    w.add(testing::ground(0.8, kNormal));
    const int b = w.add(cart(0.15, {0.15 * kNormal, Quat::FromTwoVectors(Vec3::UnitZ(), kNormal)}));
    for (int i = 0; i < 240; ++i) EXPECT_LT(w.step().momentum_error, 1e-12);
    // Four wheels of 1 kg turn with the 14 kg that move.
    const double v = kGravity * std::sin(kSlope) / (1.0 + 4.0 * 0.5 / 14.0) * 2.0;
    EXPECT_NEAR(testing::velocity(w, b).dot(kDown), v, 5e-3 * v);
  }
}

/// Runs a lone link and a rigid body of the same solid by themselves. @return the largest difference of any coordinate
double difference_from_rigid(const WorldOptions& o, const Solid& s, const Start& start, double seconds) {
  World a(o), b(o);
  for (World* w : {&a, &b}) w->add(testing::ground(s.friction));
  const int link = a.add(lone_link(s, start)), body = b.add(rigid_body(s, start));
  double most = 0.0;
  for (double t = 0.0; t < seconds; t += o.time_step) {
    a.step(), b.step();
    for (int i = 0; i < 7; ++i) most = std::max(most, std::abs(a.q(link)[i] - b.q(body)[i]));
  }
  return most;
}

TEST(LinksOnRows, ALoneLinkMovesAsARigidBodyDoes) {
  Solid bouncing = ball(0.5);
  bouncing.restitution = 0.5;
  EXPECT_LT(difference_from_rigid(rows_at(0.125), bouncing, {Vec3(0.01, 0.02, 1.2)}, 1.5), 1e-9) << "bounces";
  const Start spins{Vec3(0.01, 0.02, 0.125), Quat::Identity(), Vec3::Zero(), Vec3(0, 0, 8)};
  EXPECT_LT(difference_from_rigid(rows_at(0.125), cylinder(0.5, 0.25), spins, 1.0), 1e-3) << "spins on its face";
  const Start sunk{Vec3(0.01, 0.02, 0.45)};
  EXPECT_LT(difference_from_rigid(rows_at(0.125), ball(0.5), sunk, 1.0), 1e-3) << "is pushed out of the floor";
}

TEST(LinksOnRows, ThreeWheelsShareAWeightAsStaticsSays) {
  ArticulatedModel m;
  m.links.push_back(link_of({make_box(Vec3(0.6, 0.6, 0.1)), Vec3::Constant(0.3)}));
  m.links[0].mass = 9.0, m.links[0].joint = free_joint({Vec3(0.013, 0.007, 0.15)});
  for (const Vec3& x : {Vec3(0.5, 0.4, 0), Vec3(0.5, -0.4, 0), Vec3(-1.0, 0, 0)}) {
    m.links.push_back(link_of(ball(0.15)));
    m.links.back().parent = 0, m.links.back().joint = hinge(x);
  }
  World w(rows_at(0.0375));
  w.add(testing::ground(0.5));
  w.add(tree("cart", std::move(m)));
  testing::run(w, 0.5);
  const StepReport r = w.step();
  ASSERT_EQ(r.pairs.size(), 3u);
  for (const PairReport& p : r.pairs) EXPECT_NEAR(std::abs(p.force_on_a.z()), 4.0 * kGravity, 1e-3 * kGravity);
}

TEST(LinksOnRows, KeepMomentumWhereTreesAndABallHitEachOther) {
  World w(weightless(0.05));
  w.add(chain("a", {Vec3(-0.6, 0, 0), Quat::Identity(), Vec3(1, 0, 0)}));
  w.add(chain("b", {Vec3(-0.2, 0.3, 0.7), Quat::Identity(), Vec3(0, 0, -1)}));
  w.add(testing::ball("ball", {Vec3(0.7, 0.1, 0.1), Quat::Identity(), Vec3(-2, 0, 0)}, 0.5, 0.2, 30.0));
  const auto momentum = [&] {
    Vec3 p = Vec3::Zero();
    for (int b = 0; b < w.body_count(); ++b) p += w.body(b).linear_momentum(w.v(b));
    return p;
  };
  const Vec3 before = momentum();
  bool trees = false, mixed = false;
  for (int s = 0; s < 120; ++s) {
    const StepReport r = w.step();
    EXPECT_LT(r.momentum_error, 1e-12);
    EXPECT_LT(r.angular_error, 1e-12);
    EXPECT_LT(r.worst_overlap, 0.02);
    for (const PairReport& p : r.pairs) {
      if (p.force_on_a == Vec3::Zero()) continue;
      (p.part_b < 6 ? trees : mixed) = true;
    }
  }
  EXPECT_TRUE(trees && mixed);
  EXPECT_LT((momentum() - before).norm(), 1e-10 * before.norm());
}

TEST(LinksOnRows, LinksOfOneTreeHoldEachOtherApart) {
  // The two ends of a chain that is bent to a ring fly towards each other.
  ArticulatedModel m;
  for (int i = 0; i < 3; ++i) {
    m.links.push_back(link_of(ball(0.2)));
    m.links.back().parent = i - 1;
    m.links.back().joint = i == 0 ? free_joint({}) : hinge(Vec3(0.5, 0, 0));
    if (i > 0) m.links.back().joint.start = 1.8, m.links.back().joint.start_velocity = 2.0;
  }
  World w(weightless(0.05));
  w.add(tree("ring", std::move(m)));
  bool touched = false;
  for (int s = 0; s < 120; ++s) {
    const StepReport r = w.step();
    EXPECT_LT(r.worst_overlap, 0.02);
    EXPECT_LT(r.momentum_error, 1e-12);
    for (const PairReport& p : r.pairs) touched = touched || p.force_on_a != Vec3::Zero();
  }
  EXPECT_TRUE(touched);
}

TEST(LinksOnRows, ATipOfAnArmOfManyJointsIsHeldAsASolid) {
  // More velocities than six to a part: one solid at the end of three ball joints.
  ArticulatedModel m;
  for (int i = 0; i < 3; ++i) {
    m.links.push_back(link_of(ball(0.2)));
    if (i < 2) m.links.back().shapes.clear();
    m.links.back().parent = i - 1;
    m.links.back().joint.kind = JointKind::Ball;
    m.links.back().joint.position = i == 0 ? Vec3(0, 0, 0.5) : Vec3(0.5, 0, 0);
    m.links.back().joint.damping = 1.0;
  }
  World w(rows_at(0.05));
  w.add(testing::ground(0.5));
  const int arm = w.add(tree("arm", std::move(m)));
  EXPECT_LT(testing::run(w, 3.0), 0.02);
  EXPECT_NEAR(w.body(arm).bounds(0).lo.z(), 0.0, 0.01 * 0.05);
}

/// Two carts and a chain that fall onto each other, beside what is rigid.
World heap() {
  World w(rows_at(0.05));
  w.add(testing::ground(0.5));
  w.add(cart(0.15, {Vec3(0, 0, 0.16), Quat::Identity(), Vec3(0.5, 0, 0)}));
  w.add(chain("chain", {Vec3(-0.3, 0.05, 0.6)}, 0.12));
  w.add(testing::ball("ball", {Vec3(0.8, 0.1, 0.2)}, 0.5, 0.2));
  w.add(testing::box("box", {Vec3(0.2, 0.1, 0.9), rotation_from_vector(Vec3(0.2, 0.4, 0.1))}, 0.5, 0.25));
  return w;
}

TEST(LinksOnRows, OneOrTwoThreadsGiveTheSameBits) {
  std::vector<std::uint64_t> one;
  for (const int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    World w = heap();
    for (int s = 0; s < 90; ++s) {
      w.step();
      if (threads == 1) one.push_back(w.hash());
      ASSERT_EQ(w.hash(), one[s]) << threads << " threads, step " << s;
    }
  }
}

TEST(LinksOnRows, WhatIsResumedGoesOnBitForBit) {
  World straight = heap(), resumed = heap();
  for (int s = 0; s < 90; ++s) {
    resumed.set_state(resumed.state());  // nothing is kept over it but the state
    straight.step(), resumed.step();
    ASSERT_EQ(resumed.hash(), straight.hash()) << "step " << s;
  }
}

TEST(LinksOnRows, ALegNearItsDeadCentreIsNotTurnedRoundToRise) {
  for (const double start : {0.001, 1e-5}) {
    World w(rows_at(0.05));
    w.add(testing::ground(0.5));
    ArticulatedModel m;
    LinkModel leg = link_of({make_capsule(0.07, 0.65), Vec3(0.3, 0.3, 0.02)});
    leg.joint.kind = JointKind::Revolute, leg.joint.axis = Vec3::UnitY();
    leg.joint.position = Vec3(0, 0, 0.794), leg.joint.start = start;
    leg.shapes[0].pose.translation = leg.center_of_mass = Vec3(0, 0, -0.4);  // its foot is 1 mm below the floor
    m.links = {leg};
    auto b = std::make_unique<ArticulatedBody>(m);
    b->set_name("leg");
    const int body = w.add(std::move(b));
    double before = start;
    for (int s = 0; s < 60; ++s) {
      w.step();
      const double turn = std::abs(w.q(body)[0] - before);
      EXPECT_LT(turn, 0.15) << s;  // ten times a tenth of a voxel, at 0.4 m
      before = w.q(body)[0];
    }
    EXPECT_LT(std::abs(w.v(body)[0]), 1e-3);
  }
}

TEST(LinksOnRows, BallsStrikeEachOtherAlongTheLineOfCentresOfTheImpact) {
  // Beside the middle by 0.6 of both radii: normals at the start of the step are off by up to three degrees.
  constexpr double kSpeed = 2.0;
  const Vec3 line(0.8, -0.6, 0);
  for (const bool both : {false, true})
    for (const double e : {0.0, 0.5, 1.0})
      for (const double ahead : {0.1, 0.111, 0.122}) {
        SCOPED_TRACE(::testing::Message() << both << " " << e << " " << ahead);
        WorldOptions o = weightless(0.05);
        o.time_step = 1.0 / 60.0;
        World w(o);
        Solid solid = ball(0.2);
        solid.friction = 0.0, solid.restitution = e;
        Start s;
        s.x = Vec3(-0.32 - ahead, 0.24, 0), s.v = Vec3(kSpeed, 0, 0);
        w.add(both ? lone_link(solid, s) : rigid_body(solid, s));
        auto struck = lone_link(solid, {Vec3::Zero()});
        struck->set_name("struck");
        w.add(std::move(struck));
        double angular = 0.0;
        for (int i = 0; i < 20; ++i) {
          const StepReport r = w.step();
          ASSERT_TRUE(r.ok);
          angular = std::max(angular, r.angular_error);
        }
        const Vec3 given = 0.5 * (1.0 + e) * kSpeed * 0.8 * line;
        EXPECT_LT((Eigen::Map<const Vec3>(w.v(1).data()) - given).norm(), 2e-3);
        EXPECT_LT((Eigen::Map<const Vec3>(w.v(0).data()) - (s.v - given)).norm(), 2e-3);
        EXPECT_LT(Eigen::Map<const Vec3>(w.v(1).data() + 3).norm(), 1e-4) << "without friction";
        EXPECT_LT(angular, 1e-12);
      }
}

/// A leg under a hinge above a platform that rises, and a box tied to it at its side, whose weight turns it.
struct TiedLeg {
  World w;
  int leg = 0, box = 0;

  explicit TiedLeg(double friction, double rise) : w(options()) {
    ObstacleModel lift;
    lift.shape = make_box(Vec3(1, 1, 0.1));
    lift.part.material.friction = friction;
    lift.keys.resize(2);
    lift.keys[0].position = Vec3(0, 0, -0.055);
    lift.keys[1].time = 10.0, lift.keys[1].position = lift.keys[0].position + Vec3(0, 0, 10.0 * rise);
    auto platform = std::make_unique<ObstacleBody>(lift);
    platform->set_name("lift");
    w.add(std::move(platform));
    Solid solid{make_capsule(0.07, 0.65), Vec3(0.3, 0.3, 0.02)};
    solid.friction = friction;
    ArticulatedModel m;
    LinkModel l = link_of(solid);
    l.mass = 8.0;
    l.joint = hinge(Vec3(0, 0, 0.795));
    l.shapes[0].pose.translation = l.center_of_mass = Vec3(0, 0, -0.4);
    m.links = {l};
    leg = w.add(tree("leg", std::move(m)));
    RigidModel load;
    load.shape = make_box(Vec3::Constant(0.1));
    load.mass = 0.5, load.inertia = 0.5 / 600.0 * Mat3::Identity();
    load.position = Vec3(0.3, 0, 0.55);
    auto b = std::make_unique<RigidBody>(load);
    b->set_name("box");
    box = w.add(std::move(b));
    Attachment clasp;
    clasp.name = "clasp", clasp.body = "box", clasp.to = "leg", clasp.point = Vec3(0.3, 0, 0.6);
    w.attach(clasp);
  }
  static WorldOptions options() {
    WorldOptions o = testing::options_at(0.05);
    o.response = Response::Constraint;
    o.time_step = 1.0 / 60.0;
    return o;
  }
  double energy() {
    double sum = 0.0;
    for (const int b : {leg, box})
      sum += w.body(b).kinetic_energy(w.v(b)) + w.body(b).potential_energy(options().environment);
    return sum;
  }
};

TEST(LinksOnRows, AMechanismThatFrictionJamsStaysJammedAndGainsNoEnergy) {
  // The foot comes down 0.09 rad off upright: friction of 0.3 and more holds it, and nothing can lift the leg. Impulses
  // along the leg move nothing; rows answered with 1e14 N, and the run failed.
  for (const double friction : {0.3, 0.5, 1.0}) {
    SCOPED_TRACE(friction);
    constexpr double kRise = 0.01;
    TiedLeg t(friction, kRise);
    const double before = t.energy();
    double largest = 0.0, lifted = 0.0, jammed = 0.0;
    for (int s = 0; s < 120; ++s) {
      const StepReport r = t.w.step();
      ASSERT_TRUE(r.ok);
      EXPECT_TRUE(r.warnings.empty()) << r.warnings[0].message;
      for (const PairReport& p : r.pairs) largest = std::max(largest, p.force_on_a.norm());
      if (s == 60) jammed = t.w.q(t.leg)[0], lifted = t.energy();
    }
    EXPECT_GT(largest, 1.0);
    EXPECT_LT(largest, 1e3) << "some ten times the weight of what it holds";
    EXPECT_NEAR(t.w.q(t.leg)[0], jammed, 0.01) << "rad in a second: it stays";
    EXPECT_LT(t.energy() - lifted, 2 * 8.5 * 9.81 * kRise) << "what the platform may have lifted";
    EXPECT_LT(lifted - before, 2 * 8.5 * 9.81 * kRise);
  }
}

LinkModel finger(double side, double force) {
  LinkModel l = link_of({make_box(Vec3(0.02, 0.06, 0.08)), Vec3::Constant(1e-3)});
  l.parent = 0, l.mass = 0.2;
  l.joint.kind = JointKind::Prismatic, l.joint.axis = Vec3(-side, 0, 0), l.joint.position = Vec3(0.06 * side, 0, 0.06);
  l.joint.drive.stiffness = 2e4, l.joint.drive.damping = 50, l.joint.drive.force_limit = force;
  l.joint.drive.keys = {{0.1, 0.0}, {0.3, 0.2}};
  return l;
}

TEST(LinksOnRows, FingersThatHoldABoxByALittleMoreThanItsWeightDoNotTurnIt) {
  for (const double over : {1.03, 1.1}) {
    WorldOptions o = rows_at(0.005);
    o.time_step = 1.0 / 60.0;
    World w(o);
    w.add(testing::ground(0.5));
    ArticulatedModel m;
    LinkModel palm;
    palm.mass = 1, palm.inertia = 0.01 * Mat3::Identity();
    palm.joint.kind = JointKind::Prismatic, palm.joint.axis = Vec3::UnitZ();
    palm.joint.drive.stiffness = 5e4, palm.joint.drive.damping = 2e3;
    palm.joint.drive.keys = {{0.5, 0.0}, {2.0, 0.05}};
    const double weight = 0.5 * kGravity, grip = over * weight;  // µ is a half, on two sides
    m.links = {palm, finger(-1, grip), finger(1, grip)};
    auto b = std::make_unique<ArticulatedBody>(m);
    b->set_name("gripper");
    w.add(std::move(b));
    const int load = w.add(testing::box("load", {Vec3(0, 0, 0.04)}, 0.5, 0.08, 0.5 / (0.08 * 0.08 * 0.08)));
    for (int s = 0; s < 120; ++s) w.step();
    EXPECT_GT(testing::position(w, load).z(), 0.04 + 0.045);
    EXPECT_GT(std::abs(w.q(load)[3]), std::cos(0.5 * 0.02));  // half the angle
  }
}

}  // namespace
}  // namespace brim::links_on_rows_test
