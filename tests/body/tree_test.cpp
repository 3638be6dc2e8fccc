#include "brim/body/articulated/tree.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "brim/body/articulated/articulated_body.h"
#include "brim/core/error.h"
#include "support/trees.h"

/// Laws of the recursions over a tree; matrices are assembled by their definitions.
namespace brim::tree_test {
namespace {

using testing::mass_matrix;
using testing::random_tree;
using testing::tree_jacobian;
using testing::TreeNoise;

Eigen::Map<const Eigen::VectorXd> vec(const std::vector<double>& x) { return {x.data(), static_cast<long>(x.size())}; }

/// A random tree in a random state.
struct Case {
  ArticulatedBody body;
  const Tree& tree;
  std::vector<double> q, v;
  TreePose pose;
  explicit Case(unsigned seed, bool floating) : body(random_tree(seed, floating)), tree(body.tree()) {
    q.resize(tree.q_size()), v.resize(tree.v_size());
    body.initial_state(q, v);
    tree.place(q, pose);
  }
  std::vector<double> moved(double e) const {
    auto out = q;
    tree.move(e, v, out);
    return out;
  }
};

template <class F>
void for_trees(const F& f) {
  for (unsigned seed = 1; seed <= 6; ++seed)
    for (const bool floating : {false, true}) {
      SCOPED_TRACE(::testing::Message() << "seed " << seed << (floating ? ", floating" : ", on the world"));
      Case c(seed, floating);
      f(c, seed);
    }
}

TEST(Tree, TwoLinksByHand) {
  // An arm of length 2 turned up by 90°, with a slider along the arm at its end.
  ArticulatedModel m;
  m.links.resize(2);
  m.links[0].joint.kind = JointKind::Revolute;
  m.links[0].joint.axis = Vec3(0, -3, 0);
  m.links[0].mass = 1.0, m.links[0].inertia = Mat3::Identity();
  m.links[1].parent = 0;
  m.links[1].joint.kind = JointKind::Prismatic;
  m.links[1].joint.axis = Vec3(1, 0, 0);
  m.links[1].joint.position = Vec3(2, 0, 0);
  m.links[1].mass = 3.0, m.links[1].inertia = Mat3::Identity();
  const Tree tree(m);
  TreePose pose;
  const double right = 0.5 * 3.14159265358979323846;
  tree.place(std::vector<double>{right, 0.5}, pose);
  EXPECT_LT((pose.link[1].origin - Vec3(0, 0, 2.5)).norm(), 1e-15);
  std::vector<Vec6> V(2), a(2);
  tree.twists(pose, std::vector<double>{2.0, 1.0}, V);
  EXPECT_LT((V[1].head<3>() - Vec3(-5, 0, 1)).norm(), 1e-14);
  EXPECT_LT((V[1].tail<3>() - Vec3(0, -2, 0)).norm(), 1e-14);
  // What holds the velocities: Coriolis torque 2 m r r' w and the pull m r w² inwards.
  std::vector<double> C(2, 0.0);
  tree.add_bias(pose, std::vector<double>{2.0, 1.0}, V, a, C);
  EXPECT_NEAR(C[0], 2 * 3 * 2.5 * 1 * 2, 1e-12);
  EXPECT_NEAR(C[1], -3 * 2.5 * 4, 1e-12);
}

TEST(Tree, TwistsAreTheDerivativesOfThePlaces) {
  for_trees([](Case& c, unsigned) {
    const double e = 1e-6;
    TreePose up, down;
    c.tree.place(c.moved(e), up);
    c.tree.place(c.moved(-e), down);
    std::vector<Vec6> V(c.tree.size());
    c.tree.twists(c.pose, c.v, V);
    for (std::size_t i = 0; i < V.size(); ++i) {
      const double size = 1.0 + V[i].norm();
      EXPECT_LT((V[i].head<3>() - (up.link[i].origin - down.link[i].origin) / (2 * e)).norm(), 1e-8 * size);
      const Mat3 spin = (up.link[i].rotation - down.link[i].rotation) / (2 * e) * c.pose.link[i].rotation.transpose();
      EXPECT_LT((skew(V[i].tail<3>()) - spin).norm(), 1e-8 * size);
    }
  });
}

TEST(Tree, RateOfCoordinatesIsWhatMoveDoes) {
  for_trees([](Case& c, unsigned) {
    const double e = 1e-6;
    std::vector<double> rate(c.q.size());
    c.tree.rate(c.q, c.v, rate);
    const auto up = c.moved(e), down = c.moved(-e);
    for (std::size_t i = 0; i < rate.size(); ++i) EXPECT_NEAR(rate[i], (up[i] - down[i]) / (2 * e), 1e-8);
  });
}

TEST(Tree, MassIsTheSumOverLinksOfTheirInertia) {
  for_trees([](Case& c, unsigned seed) {
    TreeNoise noise(seed);
    const Eigen::MatrixXd M = mass_matrix(c.tree, c.pose);
    const auto x = noise.list(c.v.size());
    std::vector<double> y(x.size(), 0.0);
    std::vector<Vec6> V(c.tree.size());
    c.tree.add_mass(c.pose, x, V, y);
    EXPECT_LT((vec(y) - M * vec(x)).norm(), 1e-12 * (M * vec(x)).norm());
  });
}

TEST(Tree, BiasIsWhatDAlembertAsksForConstantJointVelocities) {
  for_trees([](Case& c, unsigned) {
    const double e = 1e-5;
    std::vector<Vec6> up(c.tree.size()), down(c.tree.size()), V(c.tree.size()), a(c.tree.size());
    TreePose p_up, p_down;
    c.tree.place(c.moved(e), p_up), c.tree.place(c.moved(-e), p_down);
    c.tree.twists(p_up, c.v, up), c.tree.twists(p_down, c.v, down), c.tree.twists(c.pose, c.v, V);
    const Eigen::MatrixXd J = tree_jacobian(c.tree, c.pose);
    Eigen::VectorXd expected = Eigen::VectorXd::Zero(J.cols());
    for (std::size_t i = 0; i < c.tree.size(); ++i) {
      const auto& l = c.tree.links()[i];
      const auto center_speed = [&](const TreePose& p, const Vec6& twist) -> Vec3 {
        return twist.head<3>() + Vec3(twist.tail<3>()).cross(p.link[i].center);
      };
      const Vec3 force = l.mass * (center_speed(p_up, up[i]) - center_speed(p_down, down[i])) / (2 * e);
      const Vec3 spin = (p_up.link[i].inertia * up[i].tail<3>() - p_down.link[i].inertia * down[i].tail<3>()) / (2 * e);
      Vec6 W;
      W << force, spin + c.pose.link[i].center.cross(force);
      expected += J.middleRows<6>(6 * i).transpose() * W;
    }
    std::vector<double> C(c.v.size(), 0.0);
    c.tree.add_bias(c.pose, c.v, V, a, C);
    EXPECT_LT((vec(C) - expected).norm(), 1e-7 * expected.norm());
    EXPECT_GT(expected.norm(), 0.1);
  });
}

TEST(TreeInverse, UndoesMassWithJointTermsAndContactOfLinks) {
  for_trees([](Case& c, unsigned seed) {
    TreeNoise noise(seed);
    Eigen::MatrixXd A = mass_matrix(c.tree, c.pose);
    const Eigen::MatrixXd J = tree_jacobian(c.tree, c.pose);
    std::vector<Mat3> T;
    std::vector<Mat6> W;
    for (std::size_t i = 0; i < c.tree.size(); ++i) {
      Mat3 t;
      t << noise.vec(), noise.vec(), noise.vec();
      T.push_back(t * t.transpose());
      Eigen::Matrix<double, 6, 3> w;
      for (int k = 0; k < 18; ++k) w.data()[k] = noise();
      W.push_back(10.0 * w * w.transpose());
      A += J.middleRows<6>(6 * i).transpose() * W.back() * J.middleRows<6>(6 * i);
      const auto& l = c.tree.links()[i];
      if (l.dof <= 3) A.block(l.v0, l.v0, l.dof, l.dof) += T.back().topLeftCorner(l.dof, l.dof);
    }
    TreeInverse inverse;
    ASSERT_TRUE(inverse.factor(c.tree, c.pose, T, W));
    const auto x = noise.list(c.v.size());
    const Eigen::VectorXd Ax = A * vec(x);
    std::vector<double> r(Ax.data(), Ax.data() + Ax.size()), z(r.size());
    std::vector<Vec6> scratch(c.tree.size());
    inverse.solve(r, scratch, z);
    EXPECT_LT((vec(z) - vec(x)).norm(), 1e-9 * vec(x).norm());
  });
}

TEST(Tree, WhatCannotBeATreeIsRefused) {
  const auto model = [] { return random_tree(1, false); };
  auto parent = model();
  parent.links[2].parent = 2;
  EXPECT_THROW(Tree{parent}, InputError);
  auto axis = model();
  axis.links[0].joint.kind = JointKind::Revolute, axis.links[0].joint.axis = Vec3::Zero();
  EXPECT_THROW(Tree{axis}, InputError);
  auto free = model();
  free.links[3].joint.kind = JointKind::Free;
  EXPECT_THROW(Tree{free}, InputError);
  auto stiff = model();
  for (auto& l : stiff.links) l.joint.kind = JointKind::Fixed;
  EXPECT_THROW(Tree{stiff}, InputError);
  auto massless = model();
  massless.links.back().joint.kind = JointKind::Revolute;
  massless.links.back().joint.armature = 0.0;
  massless.links.back().mass = 0.0, massless.links.back().inertia.setZero();
  EXPECT_THROW(ArticulatedBody{massless}, InputError);
  massless.links.back().joint.armature = 0.1;
  EXPECT_NO_THROW(ArticulatedBody{massless});
}

TEST(Tree, JacobianOfAPointIsTheTwistThereAndTheRateOfItsPlace) {
  for (const bool floating : {false, true})
    for (unsigned seed = 1; seed <= 4; ++seed) {
      SCOPED_TRACE(seed);
      const Case c(seed, floating);
      TreeNoise noise(seed);
      const int link = static_cast<int>(c.tree.size()) - 1 - static_cast<int>(seed % 3);
      const Vec3 local = noise.vec(), arm = c.pose.link[link].rotation * local;
      const auto J = c.tree.jacobian(c.pose, link, arm);
      ASSERT_EQ(J.cols(), static_cast<long>(c.tree.v_size()));
      const Eigen::MatrixXd origin = tree_jacobian(c.tree, c.pose).middleRows<6>(6 * link);
      for (int k = 0; k < J.cols(); ++k) EXPECT_LT((moved_twist(origin.col(k), arm) - J.col(k)).norm(), 1e-12);
      // The place itself, by central differences along v.
      constexpr double kEps = 1e-5;
      const auto place = [&](double e) {
        TreePose pose;
        c.tree.place(c.moved(e), pose);
        return Vec3(pose.link[link].rotation * local + pose.link[link].origin);
      };
      const Vec3 rate = (place(kEps) - place(-kEps)) / (2.0 * kEps), exact = J.topRows<3>() * vec(c.v);
      EXPECT_LT((rate - exact).norm(), 1e-7 * std::max(1.0, exact.norm()));
    }
}

}  // namespace
}  // namespace brim::tree_test
