#include "brim/body/articulated/tree_flow.h"

#include <gtest/gtest.h>

#include <cmath>

#include "brim/body/articulated/articulated_body.h"
#include "support/trees.h"

namespace brim::tree_flow_test {
namespace {

using testing::random_tree;

double kinetic_energy(const Tree& tree, const std::vector<double>& q, const std::vector<double>& v) {
  TreePose pose;
  tree.place(q, pose);
  const auto x = Eigen::Map<const Eigen::VectorXd>(v.data(), static_cast<long>(v.size()));
  return 0.5 * x.dot(testing::mass_matrix(tree, pose) * x);
}

TEST(TreeFlow, ABeadOnAFreeSpokeMovesOnAStraightLine) {
  ArticulatedModel m;
  m.links.resize(2);
  m.links[0].joint.kind = JointKind::Revolute;
  m.links[0].inertia = 1e-12 * Mat3::Identity();  // the spoke weighs nothing
  m.links[1].parent = 0;
  m.links[1].joint.kind = JointKind::Prismatic;
  m.links[1].joint.axis = Vec3(1, 0, 0);
  m.links[1].mass = 3.0;
  const Tree tree(m);
  std::vector<double> q = {0.0, 1.0}, v = {2.0, 0.5};  // at (1, 0), moving at (0.5, 2)
  TreeFlow flow;
  for (int s = 0; s < 100; ++s) flow.run(tree, 0.01, q, v);
  EXPECT_NEAR(q[1] * std::cos(q[0]), 1.5, 1e-6);
  EXPECT_NEAR(q[1] * std::sin(q[0]), 2.0, 1e-6);
}

TEST(TreeFlow, KeepsEnergyToItsToleranceWhateverTheStep) {
  for (unsigned seed = 1; seed <= 4; ++seed)
    for (const double dt : {1e-3, 1e-2, 0.05}) {
      SCOPED_TRACE(::testing::Message() << "seed " << seed << ", dt " << dt);
      ArticulatedBody body(random_tree(seed, false));
      std::vector<double> q(body.q_size()), v(body.v_size());
      body.initial_state(q, v);
      const double before = kinetic_energy(body.tree(), q, v);
      TreeFlow flow;
      flow.run(body.tree(), dt, q, v);
      EXPECT_NEAR(kinetic_energy(body.tree(), q, v) / before, 1.0, 2.0 * TreeFlow::kEnergyTolerance);
    }
}

TEST(TreeFlow, NeverAddsEnergyToATreeThatIsTooFastForIt) {
  ArticulatedBody body(random_tree(3, false));
  std::vector<double> q(body.q_size()), v(body.v_size());
  body.initial_state(q, v);
  for (double& x : v) x *= 1e4;
  const double before = kinetic_energy(body.tree(), q, v);
  TreeFlow flow;
  EXPECT_EQ(flow.run(body.tree(), 0.1, q, v), TreeFlow::kMaxPieces);
  EXPECT_LE(kinetic_energy(body.tree(), q, v), (1.0 + 3.0 * TreeFlow::kEnergyTolerance) * before);
  for (const double x : v) EXPECT_TRUE(std::isfinite(x));
}

TEST(TreeFlow, TwoHalfStepsAreOneStep) {
  ArticulatedBody body(random_tree(2, true));
  std::vector<double> q(body.q_size()), v(body.v_size());
  body.initial_state(q, v);
  auto q2 = q, v2 = v;
  TreeFlow flow;
  flow.run(body.tree(), 2e-3, q, v);
  flow.run(body.tree(), 1e-3, q2, v2);
  flow.run(body.tree(), 1e-3, q2, v2);
  for (std::size_t i = 0; i < q.size(); ++i) EXPECT_NEAR(q[i], q2[i], 1e-9);
  for (std::size_t i = 0; i < v.size(); ++i) EXPECT_NEAR(v[i], v2[i], 1e-7);
}

TEST(TreeFlow, AtRestNothingMoves) {
  ArticulatedBody body(random_tree(2, true));
  std::vector<double> q(body.q_size()), v(body.v_size());
  body.initial_state(q, v);
  std::fill(v.begin(), v.end(), 0.0);
  const auto before = q;
  TreeFlow flow;
  flow.run(body.tree(), 0.1, q, v);
  for (std::size_t i = 0; i < q.size(); ++i) EXPECT_NEAR(q[i], before[i], 1e-15);
}

TEST(TreeFlow, AShiftKeepsAFloatingTreesMomentumAndSpin) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE(seed);
    ArticulatedBody body(random_tree(seed, true));
    std::vector<double> q(body.q_size()), v(body.v_size());
    body.initial_state(q, v);
    const auto momenta = [&] {
      TreePose pose;
      const Tree& tree = body.tree();
      tree.place(q, pose);
      std::vector<Vec6> V(tree.size());
      tree.twists(pose, v, V);
      Vec3 center = Vec3::Zero();
      for (std::size_t i = 0; i < tree.size(); ++i)
        center += tree.links()[i].mass / tree.total_mass() * (pose.link[i].origin + pose.link[i].center);
      return tree.momentum(pose, V, center);
    };
    const Vec6 before = momenta();
    const std::vector<double> from = q, way = testing::TreeNoise(seed).list(body.v_size());
    TreeFlow().shift(body.tree(), way, q, v);
    EXPECT_LT((momenta() - before).norm(), 1e-11 * before.norm());
    // Where it went is read off the places.
    std::vector<double> seen(way.size());
    body.tree().way(from, q, seen);
    std::vector<double> again = from;
    body.tree().move(1.0, seen, again);
    for (std::size_t i = 0; i < q.size(); ++i) EXPECT_NEAR(again[i], q[i], 1e-12);
  }
}

}  // namespace
}  // namespace brim::tree_flow_test
