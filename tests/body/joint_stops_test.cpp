#include "brim/body/articulated/joint_stops.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <random>

#include "brim/body/articulated/articulated_body.h"
#include "brim/body/articulated/chain_model.h"
#include "support/trees.h"
#include "support/worlds.h"

namespace brim::joint_stops_test {
namespace {

using testing::TreeNoise;

constexpr double kFrame = 1.0 / 60.0, kBend = 1.2;

ArticulatedModel bent_chain(JointKind joint, bool floating, double stiffness = 0.0) {
  ChainOptions o;
  o.links = 8, o.length = 0.12, o.radius = 0.03;
  o.joint = joint, o.floating = floating;
  o.each.upper = kBend, o.each.limit_stiffness = stiffness;
  if (joint == JointKind::Revolute) o.each.lower = -kBend;
  ArticulatedModel m = chain_model(o);
  m.links[0].joint.upper = std::numeric_limits<double>::infinity();
  m.links[0].joint.lower = -m.links[0].joint.upper;
  return m;
}

/// A body that moves by itself, step by step.
struct Alone {
  ArticulatedBody body;
  std::vector<double> q, v;
  double time = 0.0;

  explicit Alone(const ArticulatedModel& m) : body(m), q(body.q_size()), v(body.v_size()) {
    body.initial_state(q, v);
    body.update(0.0, q, v);
  }
  void step(double dt, const Vec3& gravity = Vec3::Zero()) {
    body.begin_solve(dt);
    BlockDiagonal none;
    none.reset(body.block_sizes());
    body.prepare_preconditioner(0, none);
    std::vector<double> load(v.size(), 0.0), change(v.size(), 0.0);
    body.add_forces({gravity}, load);
    body.apply_stiffness(v, change);
    for (std::size_t i = 0; i < v.size(); ++i) load[i] = dt * (load[i] + dt * change[i]);
    body.precondition(0, none, load, change);
    for (std::size_t i = 0; i < v.size(); ++i) v[i] += change[i];
    body.advance(dt, q, v);
    body.finish_step(time, dt, q, v);
    body.update(time += dt, q, v);
  }
  double kinetic_energy() const {
    std::vector<double> p(v.size(), 0.0);
    body.apply_mass(v, p);
    double e = 0.0;
    for (std::size_t i = 0; i < v.size(); ++i) e += 0.5 * v[i] * p[i];
    return e;
  }
  /// How far the joints are beyond the bend at most, [rad].
  double beyond() const {
    double most = 0.0;
    for (const Tree::Link& l : body.tree().links())
      if (l.parent >= 0) most = std::max(most, joint_displacement(l.dof, q.data() + l.q0).norm() - kBend);
    return most;
  }
};

/// Divisions of 1/60 s: as it is, fine, and jumping as a fast body lets them.
int pieces(int rule, int frame, std::mt19937& rng) {
  if (rule == 0) return 1;
  if (rule == 1) return 36;
  if (rule == 2) return frame % 2 == 0 ? 1 : 64;
  return static_cast<int>(1 + rng() % 64);
}

TEST(JointStops, AChainThatIsStruckNeverGainsEnergyHoweverItsStepsAreDivided) {
  for (const JointKind joint : {JointKind::Ball, JointKind::Revolute})
    for (const bool floating : {false, true})
      for (int rule = 0; rule < 4; ++rule) {
        SCOPED_TRACE(::testing::Message() << (joint == JointKind::Ball ? "ball" : "revolute")
                                          << (floating ? ", free" : "") << ", rule " << rule);
        Alone chain(bent_chain(joint, floating));
        std::mt19937 rng(1);
        TreeNoise noise(1);
        for (std::size_t i = floating ? 6 : 0; i < chain.v.size(); ++i) chain.v[i] = 60.0 * noise();
        chain.body.update(0.0, chain.q, chain.v);
        const double start = chain.kinetic_energy();
        double before = start, gain = 0.0;
        for (int frame = 0; frame < 20; ++frame) {
          const int n = pieces(rule, frame, rng);
          for (int p = 0; p < n; ++p) {
            chain.step(kFrame / n);
            const double now = chain.kinetic_energy();
            gain = std::max(gain, now - before);
            before = now;
          }
        }
        EXPECT_LE(gain, 3.0 * TreeFlow::kEnergyTolerance * start);
        EXPECT_LT(chain.beyond(), 0.3);  // at 1/60 s a joint turns by more than its range in a step
      }
}

TEST(JointStops, AJointFarBeyondItsLimitReturnsWithoutEnergy) {
  for (const double stiffness : {0.0, 1e6})
    for (const int n : {1, 64}) {
      SCOPED_TRACE(::testing::Message() << "stiffness " << stiffness << ", " << n << " sub-steps");
      Alone chain(bent_chain(JointKind::Revolute, true, stiffness));
      for (std::size_t i = 1; i < chain.body.tree().size(); ++i) chain.q[chain.body.tree().links()[i].q0] = 1.5;
      chain.body.update(0.0, chain.q, chain.v);
      for (int s = 0; s < 12 * n; ++s) chain.step(kFrame / n);
      EXPECT_LT(chain.kinetic_energy(), 1e-20);
      EXPECT_LT(chain.beyond(), 0.3 * 0.02);
    }
}

TEST(JointStops, ALimitHoldsAWeightToAHundredthOfItsFallAndAtRest) {
  const double g = 9.81;
  ArticulatedModel m = bent_chain(JointKind::Revolute, false);
  m.links.resize(1);
  m.links[0].joint.upper = 0.2, m.links[0].joint.start = 0.2;
  Alone held(m);
  std::mt19937 rng(2);
  for (int frame = 0; frame < 120; ++frame) {
    const int n = frame < 60 ? pieces(3, frame, rng) : 1;
    for (int p = 0; p < n; ++p) held.step(kFrame / n, Vec3(0, 0, -g));
  }
  // The angular fall of a rod about its end in a step, from rest: at most 3/2 g dt² / length.
  EXPECT_NEAR(held.q[0], 0.2, 0.01 * 1.5 * g * kFrame * kFrame / 0.12);
  EXPECT_GT(held.q[0], 0.2);
  EXPECT_NEAR(held.v[0], 0.0, 1e-9);
}

TEST(JointStops, TakeTheEnergyThatTheySayAndNoMomentum) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    ArticulatedModel m = testing::random_tree(seed, true);
    for (LinkModel& l : m.links)
      if (l.joint.kind != JointKind::Free) l.joint.upper = 0.1, l.joint.lower = -0.1;
    const Tree tree(m);
    JointStops stops(m);
    TreePose pose;
    TreeInverse inverse;
    TreeNoise noise(seed);
    std::vector<double> q(tree.q_size()), v = noise.list(tree.v_size());
    auto still = v;
    ArticulatedBody(m).initial_state(q, still);
    tree.place(q, pose);
    const std::vector<Mat3> none(tree.size(), Mat3::Zero());
    inverse.factor(tree, pose, none);
    stops.choose(0.01, inverse);
    const auto ahead = stops.ahead(tree, 0.01, q, v);
    ASSERT_FALSE(ahead.empty());
    const Eigen::MatrixXd M = testing::mass_matrix(tree, pose);
    const auto vector = [](const std::vector<double>& x) {
      return Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<long>(x.size()));
    };
    const Eigen::VectorXd before = vector(v);
    const double taken = stops.hold(tree, pose, inverse, none, ahead, v);
    const Eigen::VectorXd after = vector(v);
    EXPECT_GT(taken, 0.0);
    EXPECT_NEAR(0.5 * before.dot(M * before) - 0.5 * after.dot(M * after), taken, 1e-12 * before.dot(M * before));
    EXPECT_LT((M * (after - before)).head<6>().norm(), 1e-12 * (M * before).norm());
    for (const JointStop& s : ahead) {
      double rate = 0.0;
      for (int k = 0; k < tree.links()[s.link].dof; ++k) rate += s.outwards[k] * v[tree.links()[s.link].v0 + k];
      EXPECT_LE(rate, s.most + 1e-6);
    }
  }
}

/// A weak spring holds a door on its limit; a ball strikes it at the distance r from the hinge and stays with it:
/// ω = m r v / (I + m r²). A limit that pulled back within the step took three quarters of that.
TEST(JointStops, ADoorThatRestsOnItsLimitIsSetGoingByABlow) {
  const double r = 0.35, v = 2.69, radius = 0.1, m = 700.0 * 4.0 / 3.0 * std::numbers::pi * 1e-3;
  const Vec3 size(0.05, 0.7, 0.4);
  const double mass = 200.0 * size.prod(), own = mass * (size.x() * size.x() + size.y() * size.y()) / 12.0;
  for (const JointKind kind : {JointKind::Revolute, JointKind::Prismatic})
    for (const int substeps : {1, 8}) {
      const bool turns = kind == JointKind::Revolute;
      ArticulatedModel model;
      LinkModel leaf;
      leaf.joint.kind = kind, leaf.joint.position = Vec3(0, r, 0);
      leaf.joint.axis = turns ? Vec3(0, 0, 1) : Vec3(1, 0, 0);
      leaf.joint.lower = 0.0;
      leaf.joint.drive.stiffness = 1.0, leaf.joint.drive.target = -0.1;
      leaf.mass = mass, leaf.inertia = own * Mat3::Identity();
      leaf.center_of_mass = Vec3(0, -r, 0);
      leaf.shapes = {LinkShape{make_box(size), Pose{Mat3::Identity(), Vec3(0, -r, 0)}, {}, {}}};
      model.links = {leaf};
      WorldOptions o = testing::options_at(0.025);
      o.environment.gravity = Vec3::Zero();
      o.time_step = 1.0 / 120.0, o.response = Response::Constraint, o.min_substeps = substeps;
      World w(o);
      w.add(std::make_unique<ArticulatedBody>(std::move(model)));
      w.add(testing::ball("ball", {Vec3(-0.4, 0, 0), Quat::Identity(), Vec3(v, 0, 0)}, 0.0, radius, 700.0));
      double most = 0.0;
      for (int s = 0; s < 40; ++s) {
        EXPECT_LT(w.step().kinetic_energy, 1.001 * 0.5 * m * v * v);
        most = std::max(most, w.v(0)[0]);
      }
      const double theory = turns ? m * r * v / (own + mass * r * r + m * r * r) : m * v / (m + mass);
      EXPECT_NEAR(most, theory, 0.03 * theory) << (turns ? "hinge" : "slide") << ", sub-steps " << substeps;
    }
}

}  // namespace
}  // namespace brim::joint_stops_test
