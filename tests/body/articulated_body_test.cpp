#include "brim/body/articulated/articulated_body.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "brim/body/articulated/chain_model.h"
#include "brim/body/fem/fem_body.h"
#include "brim/core/parallel.h"
#include "brim/world/body_motion.h"
#include "support/solids.h"
#include "support/trees.h"
#include "support/worlds.h"

/// What trees of links do, alone and among other bodies.
namespace brim::articulated_body_test {
namespace {

using testing::random_tree;

constexpr double kPi = std::numbers::pi, kGravity = 9.81;

/// A point of mass 1 at the end of a weightless rod along −z, hinged about y.
LinkModel rod(double length, int parent) {
  LinkModel l;
  l.parent = parent;
  l.joint.kind = JointKind::Revolute;
  l.joint.axis = Vec3(0, -1, 0);
  l.mass = 1.0;
  l.center_of_mass = Vec3(0, 0, -length);
  return l;
}

World alone(ArticulatedModel m, double dt, const Vec3& gravity = Vec3(0, 0, -kGravity)) {
  WorldOptions o;
  o.time_step = dt;
  o.environment.gravity = gravity;
  o.cg_tolerance = 1e-12;
  World w(o);
  auto b = std::make_unique<ArticulatedBody>(std::move(m));
  b->set_name("tree");
  w.add(std::move(b));
  return w;
}

double energy(World& w) {
  return w.body(0).kinetic_energy(w.v(0)) + w.body(0).potential_energy(w.options().environment);
}

/// Period of a pendulum let go at an angle, from its zero crossings.
double period(double angle, double length, double dt) {
  ArticulatedModel m;
  m.links = {rod(length, -1)};
  m.links[0].joint.start = angle;
  World w = alone(m, dt);
  std::vector<double> crossings;
  double before = angle;
  while (crossings.size() < 7 && w.state().time < 60.0) {
    w.step();
    const double now = w.q(0)[0];
    if (before * now < 0.0) crossings.push_back(w.state().time - dt * now / (now - before));
    before = now;
  }
  return (crossings.back() - crossings.front()) / 3.0;
}

TEST(ArticulatedBody, APendulumOfLargeAmplitudeKeepsThePeriodOfTheEllipticIntegral) {
  const double length = 0.8;
  for (const double angle : {0.1, 1.5, 2.6}) {
    SCOPED_TRACE(angle);
    const double exact = 4.0 * std::sqrt(length / kGravity) * std::comp_ellint_1(std::sin(0.5 * angle));
    const double coarse = period(angle, length, 1.0 / 60.0) / exact - 1.0;
    const double fine = period(angle, length, 1.0 / 240.0) / exact - 1.0;
    RecordProperty("period_error_60Hz_" + std::to_string(angle), std::to_string(coarse));
    RecordProperty("period_error_240Hz_" + std::to_string(angle), std::to_string(fine));
    EXPECT_LT(std::abs(coarse), 3e-4);
    EXPECT_LT(std::abs(fine), 2e-5);
    EXPECT_NEAR(coarse / fine, 16.0, 3.0) << "second order";
  }
}

/// The double pendulum's own equations (two point masses of 1 kg, rods l1, l2; angles from −z), classical Runge-Kutta.
std::array<double, 4> double_pendulum(std::array<double, 4> y, double l1, double l2, double time, int steps) {
  const auto f = [&](const std::array<double, 4>& s) -> std::array<double, 4> {
    const auto [a, b, u, w] = s;
    const double d = a - b, c = std::cos(d), n = std::sin(d);
    // [2 l1, l2 c; l1 c, l2] (u', w') = right-hand sides
    const double r1 = -l2 * w * w * n - 2.0 * kGravity * std::sin(a), r2 = l1 * u * u * n - kGravity * std::sin(b);
    const double det = 2.0 * l1 * l2 - l1 * l2 * c * c;
    return {u, w, (r1 * l2 - l2 * c * r2) / det, (2.0 * l1 * r2 - l1 * c * r1) / det};
  };
  const auto plus = [](std::array<double, 4> s, const std::array<double, 4>& d, double e) {
    for (int i = 0; i < 4; ++i) s[i] += e * d[i];
    return s;
  };
  const double h = time / steps;
  for (int i = 0; i < steps; ++i) {
    const auto k1 = f(y), k2 = f(plus(y, k1, h / 2)), k3 = f(plus(y, k2, h / 2)), k4 = f(plus(y, k3, h));
    for (int j = 0; j < 4; ++j) y[j] += h / 6 * (k1[j] + 2 * k2[j] + 2 * k3[j] + k4[j]);
  }
  return y;
}

ArticulatedModel two_rods() {
  ArticulatedModel m;
  m.links = {rod(1.0, -1), rod(0.7, 0)};
  m.links[1].joint.position = Vec3(0, 0, -1.0);
  m.links[0].joint.start = 2.0, m.links[1].joint.start = 0.7;
  return m;
}

TEST(ArticulatedBody, ADoublePendulumFollowsItsEquationsAtFirstOrder) {
  const auto exact = double_pendulum({2.0, 2.7, 0.0, 0.0}, 1.0, 0.7, 2.0, 200000);
  const auto miss = [&](int steps) {
    World w = alone(two_rods(), 2.0 / steps);
    for (int s = 0; s < steps; ++s) w.step();
    return std::hypot(w.q(0)[0] - exact[0], w.q(0)[0] + w.q(0)[1] - exact[1]);
  };
  const double coarse = miss(2000), fine = miss(8000);
  RecordProperty("miss_1ms", std::to_string(coarse));
  RecordProperty("miss_quarter_ms", std::to_string(fine));
  EXPECT_LT(fine, 5e-3);
  EXPECT_NEAR(coarse / fine, 4.0, 0.5);
}

TEST(ArticulatedBody, ADoublePendulumNeitherGainsNorLosesEnergyInTenSeconds) {
  World w = alone(two_rods(), 1e-3);
  const double start = energy(w), scale = 3.0 * kGravity * 1.7;
  double first = 0.0, last = 0.0, worst = 0.0;
  for (int s = 0; s < 10000; ++s) {
    w.step();
    const double off = (energy(w) - start) / scale;
    worst = std::max(worst, std::abs(off));
    (s < 5000 ? first : last) += off / 5000.0;
  }
  RecordProperty("worst", std::to_string(worst));
  RecordProperty("drift_of_the_mean", std::to_string(last - first));
  EXPECT_LT(worst, 2e-3);
  EXPECT_LT(std::abs(last - first), 1e-3);
}

TEST(ArticulatedBody, AFloatingTreeKeepsItsMomentumAndEnergy) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE(seed);
    World w = alone(random_tree(seed, true), 1.0 / 240.0, Vec3::Zero());
    const Body& b = w.body(0);
    const Vec3 P = b.linear_momentum(w.v(0)), L = b.angular_momentum(w.v(0));
    const double E = b.kinetic_energy(w.v(0));
    for (int s = 0; s < 240; ++s) w.step();
    EXPECT_LT((b.linear_momentum(w.v(0)) - P).norm(), 1e-11 * P.norm());
    EXPECT_LT((b.angular_momentum(w.v(0)) - L).norm(), 1e-10 * L.norm());
    EXPECT_NEAR(b.kinetic_energy(w.v(0)) / E, 1.0, 1e-5);
    RecordProperty("energy_" + std::to_string(seed), std::to_string(b.kinetic_energy(w.v(0)) / E - 1.0));
  }
}

TEST(ArticulatedBody, AFloatingTreeFallsOnAParabola) {
  World w = alone(random_tree(2, true), 0.01);
  const Body& b = w.body(0);
  const Vec3 P = b.linear_momentum(w.v(0));
  for (int s = 0; s < 50; ++s) w.step();
  EXPECT_LT((b.linear_momentum(w.v(0)) - P - 0.5 * b.mass() * Vec3(0, 0, -kGravity)).norm(), 1e-9 * P.norm());
}

TEST(ArticulatedBody, ADriveHoldsItsTargetUpToItsForceLimit) {
  for (const double limit : {20.0, 5.0}) {  // the weight asks for 7.8 N m
    SCOPED_TRACE(limit);
    ArticulatedModel m;
    m.links = {rod(0.8, -1)};
    m.links[0].joint.start = 0.5 * kPi;
    m.links[0].joint.drive = {1e5, 1e3, limit, 0.5 * kPi, 0.0, {}};
    World w = alone(m, 1.0 / 60.0);
    for (int s = 0; s < 60; ++s) w.step();
    if (limit > 10.0)
      EXPECT_NEAR(w.q(0)[0], 0.5 * kPi, 1e-3);
    else
      EXPECT_LT(w.q(0)[0], 1.0) << "where the weight and the drive balance: asin(5 / 7.85) = 0.69";
  }
}

TEST(ArticulatedBody, ADriveFollowsItsKeys) {
  ArticulatedModel m;
  m.links = {rod(0.8, -1)};
  m.links[0].joint.drive = {1e5, 1e3, 1e9, 0.0, 0.0, {{0.5, 0.0}, {1.5, 1.0}}};
  World w = alone(m, 0.01);
  double worst = 0.0;
  for (int s = 0; s < 200; ++s) {
    w.step();
    worst = std::max(worst, std::abs(w.q(0)[0] - std::clamp(w.state().time - 0.5, 0.0, 1.0)));
  }
  EXPECT_LT(worst, 2e-3);
}

TEST(ArticulatedBody, ALimitStopsAJointWithoutBounceOrAdhesion) {
  ArticulatedModel m;
  m.links = {rod(0.8, -1)};
  m.links[0].joint.start = 1.0, m.links[0].joint.lower = 0.2;
  World w = alone(m, 1.0 / 120.0);
  double least = 1.0, most_after = 0.0;
  bool stopped = false;
  for (int s = 0; s < 240; ++s) {
    w.step();
    least = std::min(least, w.q(0)[0]);
    stopped = stopped || w.q(0)[0] < 0.201;
    if (stopped) most_after = std::max(most_after, w.q(0)[0]);
  }
  EXPECT_TRUE(stopped);
  EXPECT_GT(least, 0.2 - 1e-3);
  EXPECT_LT(most_after, 0.21);
  State state = w.state();  // pushed off, it must come free at once
  state.v[0] = 0.5;
  w.set_state(state);
  w.step();
  EXPECT_GT(w.v(0)[0], 0.3);
}

TEST(ArticulatedBody, DryFrictionHoldsALightLoadAndBrakesAtItsTorque) {
  ArticulatedModel m;
  m.links = {rod(0.8, -1)};
  m.links[0].joint.start = 0.5 * kPi;
  m.links[0].joint.friction = 10.0;  // the weight asks for 7.8 N m
  World held = alone(m, 1.0 / 120.0);
  for (int s = 0; s < 120; ++s) held.step();
  RecordProperty("creep_rad_per_s", std::to_string(0.5 * kPi - held.q(0)[0]));
  EXPECT_NEAR(held.q(0)[0], 0.5 * kPi, 2e-3);
  m.links[0].joint.friction = 0.5, m.links[0].joint.start_velocity = 4.0;
  World braked = alone(m, 1.0 / 480.0, Vec3::Zero());
  for (int s = 0; s < 240; ++s) braked.step();
  EXPECT_NEAR(braked.v(0)[0], 4.0 - 0.5 * 0.5 / 0.64, 0.02);
}

TEST(ArticulatedBody, NeighboursAreNeverPairedOthersAre) {
  ChainOptions o;
  o.links = 4;
  ArticulatedModel m = chain_model(o);
  m.no_contact = {{0, 3}};
  const ArticulatedBody b(m);
  EXPECT_FALSE(b.parts_collide(0, 0));
  EXPECT_FALSE(b.parts_collide(1, 2));
  EXPECT_FALSE(b.parts_collide(2, 1));
  EXPECT_TRUE(b.parts_collide(0, 2));
  EXPECT_FALSE(b.parts_collide(3, 0));
  m.links[1].joint.kind = JointKind::Fixed;  // links 0 and 1 are one: now 2 is the neighbour of both
  EXPECT_FALSE(ArticulatedBody(m).parts_collide(0, 2));
  m.self_collision = false;
  EXPECT_FALSE(ArticulatedBody(m).parts_collide(1, 3));
}

TEST(ArticulatedBody, SpeedBoundHoldsForEveryVertexOfALink) {
  ChainOptions o;
  o.links = 5;
  o.floating = true;
  ArticulatedBody b(chain_model(o));
  testing::TreeNoise noise(7);
  auto q = noise.list(b.q_size()), v = noise.list(b.v_size());
  b.update(0.0, q, v);
  const double e = 1e-6;
  std::vector<Vec3f> x(b.display().vertices);
  const auto at = [&](double t) {
    auto moved = q;
    b.advance(t, moved, v);
    b.update(0.0, moved, v);
    std::vector<Aabb> boxes;
    for (int p = 0; p < b.part_count(); ++p) boxes.push_back(b.bounds(p));
    return boxes;
  };
  const auto up = at(e), down = at(-e);
  b.update(0.0, q, v);
  for (int p = 0; p < b.part_count(); ++p) {
    const Vec3 travel = (up[p].center() - down[p].center()) / (2 * e);
    EXPECT_LT((travel - b.mean_velocity(p, v)).norm(), 1e-4 * (1.0 + travel.norm()));
    const double faces =
        std::max((up[p].hi - down[p].hi).cwiseAbs().maxCoeff(), (up[p].lo - down[p].lo).cwiseAbs().maxCoeff()) /
        (2 * e);
    EXPECT_GE(b.mean_velocity(p, v).norm() + b.relative_speed_bound(p, v), faces - 1e-6);
  }
}

/// A floating chain over what another body offers; @return lowest point of the chain after a time.
struct Fallen {
  double height, overlap, speed, momentum_error;
};
Fallen fall(std::unique_ptr<Body> floor, double drop, double top) {
  WorldOptions w_options;
  w_options.voxel_size = 0.02;
  w_options.time_step = 1.0 / 120.0;
  World w(w_options);
  w.add(testing::ground(0.5));
  if (floor) w.add(std::move(floor));
  ChainOptions o;
  o.links = 3, o.length = 0.2, o.radius = 0.05, o.floating = true;
  o.position = Vec3(-0.3, 0.01, top + o.radius + drop);
  o.each.damping = 1e-3;
  auto chain = std::make_unique<ArticulatedBody>(chain_model(o));
  chain->set_name("chain");
  const int b = w.add(std::move(chain));
  Fallen f{0, 0, 0, 0};
  for (int s = 0; s < 120; ++s) {
    const StepReport r = w.step();
    EXPECT_TRUE(r.ok);
    f.overlap = std::max(f.overlap, r.worst_overlap);
    f.momentum_error = std::max(f.momentum_error, std::max(r.momentum_error, r.angular_error));
  }
  f.height = std::numeric_limits<double>::infinity();
  for (int p = 0; p < 3; ++p) {
    f.height = std::min(f.height, w.body(b).bounds(p).lo.z());
    f.speed = std::max(f.speed, w.body(b).mean_velocity(p, w.v(b)).norm());
  }
  return f;
}

/// Two chains, one on the other, on the ground.
World pile() {
  WorldOptions w_options;
  w_options.voxel_size = 0.025;
  World w(w_options);
  w.add(testing::ground(0.5));
  for (int i = 0; i < 2; ++i) {
    ChainOptions o;
    o.links = 4, o.length = 0.2, o.radius = 0.05, o.floating = true;
    o.position = i == 0 ? Vec3(-0.4, 0.01, 0.06) : Vec3(0.02, -0.4, 0.18);
    o.rotation = rotation_from_vector(Vec3(0, 0, 0.5 * kPi * i));
    o.each.friction = 0.01;
    auto chain = std::make_unique<ArticulatedBody>(chain_model(o));
    chain->set_name("chain" + std::to_string(i));
    w.add(std::move(chain));
  }
  return w;
}

TEST(ArticulatedBody, AnyNumberOfThreadsAndAResumedRunGiveTheSameBits) {
  std::vector<std::uint64_t> one;
  State middle;
  for (const int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    World w = pile();
    for (int s = 0; s < 40; ++s) {
      w.step();
      if (threads == 1) one.push_back(w.hash());
      ASSERT_EQ(w.hash(), one[s]) << threads << " threads, step " << s;
      if (s == 19) middle = w.state();
    }
  }
  World resumed = pile();
  resumed.set_state(middle);
  for (int s = 20; s < 40; ++s) resumed.step();
  EXPECT_EQ(resumed.hash(), one.back());
  EXPECT_GT(resumed.contacts().size(), 0u);
}

TEST(ArticulatedBody, ItsOwnInverseLeavesTheSolveLittleToDo) {
  World w = pile();
  int iterations = 0, solves = 0;
  for (int s = 0; s < 60; ++s) {
    const StepReport r = w.step();
    iterations += r.cg_iterations, solves += r.solves;
  }
  RecordProperty("iterations_per_solve", std::to_string(1.0 * iterations / solves));
  EXPECT_LT(iterations, 12 * solves);  // measured 8.6
}

TEST(ArticulatedBody, AChainComesToRestOnAPlane) {
  const Fallen f = fall(nullptr, 0.1, 0.0);
  EXPECT_NEAR(f.height, 0.0, 0.002);
  EXPECT_LT(f.overlap, 0.5);
  EXPECT_LT(f.speed, 0.02);
  EXPECT_LT(f.momentum_error, 1e-12);
}

TEST(ArticulatedBody, AChainComesToRestOnARigidBox) {
  const Fallen f = fall(testing::box("box", {Vec3(0, 0, 0.4)}, 0.5, 0.8), 0.05, 0.8);
  EXPECT_NEAR(f.height, 0.8, 0.004);
  EXPECT_LT(f.speed, 0.05);
  EXPECT_LT(f.momentum_error, 1e-12);
}

TEST(ArticulatedBody, AChainComesToRestOnASoftBlock) {
  TetMesh mesh = testing::block(8, 3, 2, 0.1);
  for (Vec3& x : mesh.vertices) x += Vec3(-0.4, -0.15, 0.0);
  FemOptions o;
  o.young = 2e5, o.density = 500.0, o.stiffness_damping = 0.02;
  auto jelly = std::make_unique<FemBody>(mesh, o);
  jelly->set_name("jelly");
  const Fallen f = fall(std::move(jelly), 0.05, 0.2);
  EXPECT_GT(f.height, 0.16);
  EXPECT_LT(f.height, 0.205);
  EXPECT_LT(f.speed, 0.05);
  EXPECT_LT(f.momentum_error, 1e-12);
}

TEST(ArticulatedBody, PartsTurnAsTheTreeMovesFreely) {
  for (const unsigned seed : {1u, 2u, 3u})
    for (const bool floating : {false, true}) {
      ArticulatedModel m = random_tree(seed, floating);
      for (LinkModel& l : m.links) l.shapes = {LinkShape{make_box(Vec3(0.1, 0.2, 0.3)), {}, {}, {}}};
      ArticulatedBody body(m);
      std::vector<double> q(body.q_size()), v(body.v_size());
      body.initial_state(q, v);
      body.update(0.0, q, v);
      std::vector<Turns::Turn> turn(static_cast<std::size_t>(body.part_count()));
      body.turns(v, turn);
      const TreePose before = body.pose();
      std::vector<Vec6> twist(body.tree().size());
      body.tree().twists(before, v, twist);
      constexpr double kStep = 1e-4;
      std::vector<double> q_end = q, v_end = v;
      body.advance(kStep, q_end, v);
      body.finish_step(0.0, kStep, q_end, v_end);
      TreePose after;
      body.tree().place(q_end, after);
      for (std::size_t i = 0; i < turn.size(); ++i) {
        const Vec3 local(0.3, -0.2, 0.5), arm = before.link[i].rotation * local;
        const Vec3 x = before.link[i].origin + arm, w = turn[i].spin, d = x - turn[i].center;
        const Vec3 way = after.link[i].origin + after.link[i].rotation * local - x;
        const Vec3 more = way / kStep - moved_twist(twist[i], arm).head<3>();
        const Vec3 told = 0.5 * kStep * (turn[i].acceleration + turn[i].spin_change.cross(d) + w.cross(w.cross(d)));
        EXPECT_LT((more - told).norm(), 5e-3 * told.norm() + 1e-9) << seed << " link " << i;
      }
    }
}

TEST(ArticulatedBody, RestsOnALimit) {
  for (const JointKind kind : {JointKind::Revolute, JointKind::Ball})
    for (const double dt : {1.0 / 60.0, 1.0 / 240.0}) {
      ArticulatedModel m;
      m.links = {rod(1.0, -1)};
      m.links[0].inertia = 0.01 * Mat3::Identity();
      JointModel& j = m.links[0].joint;
      j.kind = kind, j.rotation = rotation_from_vector(Vec3(0, kPi / 2, 0));  // level
      if (kind == JointKind::Revolute)
        j.lower = -0.1, j.upper = 0.1;
      else
        j.upper = 0.1;
      World w = alone(m, dt);
      while (w.state().time < 2.0) w.step();
      EXPECT_LT(std::abs(w.v(0)[kind == JointKind::Ball ? 1 : 0]), 1e-6) << dt;
    }
}

TEST(ArticulatedBody, CentreOfMassIsThatOfAllLinksWhateverTheBase) {
  for (const bool floating : {false, true}) {
    const ArticulatedModel model = random_tree(3, floating);
    const ArticulatedBody body(model);
    Vec3 moment = Vec3::Zero();
    double mass = 0.0;
    for (std::size_t i = 0; i < model.links.size(); ++i) {
      const TreePose::Link& at = body.pose().link[i];
      moment += model.links[i].mass * (at.rotation * model.links[i].center_of_mass + at.origin);
      mass += model.links[i].mass;
    }
    EXPECT_LT((body.mass_center() - moment / mass).norm(), 1e-12);
    EXPECT_DOUBLE_EQ(body.mass(), mass);
    EXPECT_EQ(*center_of_mass(body), body.mass_center());
  }
}

TEST(ArticulatedBody, EffortOfADriveIsItsLawWithinItsLimit) {
  ArticulatedModel m;
  m.links = {rod(1.0, -1), rod(1.0, 0)};
  m.links[1].joint.drive.stiffness = 50, m.links[1].joint.drive.damping = 4, m.links[1].joint.drive.force_limit = 20;
  m.links[1].joint.drive.target = 0.5;
  ArticulatedBody body(m);
  const std::vector<double> q = {0.1, 0.2}, v = {1.0, 2.0}, far = {0.1, -3.0};
  ASSERT_EQ(body.drive_names().size(), 1u);
  EXPECT_EQ(body.driven_link(0), 1);
  EXPECT_DOUBLE_EQ(body.drive_effort(0, 0.0, q, v), 50 * 0.3 - 4 * 2.0);
  EXPECT_DOUBLE_EQ(body.drive_effort(0, 0.0, far, v), 20.0);
  body.aim_drive(0, DriveAim{0.2, 3.0});
  EXPECT_DOUBLE_EQ(body.drive_effort(0, 0.0, q, v), 4 * 1.0);
  body.aim_drive(0, std::nullopt);
  EXPECT_DOUBLE_EQ(body.drive_effort(0, 0.0, q, v), 50 * 0.3 - 4 * 2.0);
}

}  // namespace
}  // namespace brim::articulated_body_test
