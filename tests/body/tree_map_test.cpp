#include "brim/body/articulated/tree_map.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "brim/body/articulated/articulated_body.h"
#include "support/trees.h"

namespace brim::tree_map_test {
namespace {

using testing::random_tree;
using testing::TreeNoise;

constexpr int kPoints = 20;

/// Points carried by the last link of a random tree.
struct Case {
  ArticulatedBody body;
  const Tree& tree;
  TreeNoise noise;
  std::vector<double> q, v;
  TreePose pose;
  int link;
  std::vector<Vec3> local, points, forces;
  TreeMap map;

  Case(unsigned seed, bool floating)
      : body(random_tree(seed, floating)), tree(body.tree()), noise(seed), q(tree.q_size()), v(tree.v_size()) {
    body.initial_state(q, v);
    tree.place(q, pose);
    link = static_cast<int>(tree.size()) - 1;
    for (int i = 0; i < kPoints; ++i) local.push_back(noise.vec()), forces.push_back(noise.vec());
    points = placed(pose);
    map.reset(tree, pose, link, points, nullptr);
  }
  std::vector<Vec3> placed(const TreePose& p) const {
    std::vector<Vec3> x;
    for (const Vec3& l : local) x.push_back(p.link[link].origin + p.link[link].rotation * l);
    return x;
  }
  TreePose moved(double e) const {
    auto moved_q = q;
    tree.move(e, v, moved_q);
    TreePose p;
    tree.place(moved_q, p);
    return p;
  }
};

template <class F>
void for_trees(const F& f) {
  for (unsigned seed = 1; seed <= 8; ++seed)
    for (const bool floating : {false, true}) {
      SCOPED_TRACE(::testing::Message() << "seed " << seed << (floating ? ", floating" : ", on the world"));
      Case c(seed, floating);
      f(c);
    }
}

TEST(TreeMap, ForceIsTheTransposeOfVelocity) {
  for_trees([](Case& c) {
    std::vector<Vec3> u(kPoints);
    c.map.apply(c.v, u);
    std::vector<double> Q(c.v.size(), 0.0);
    c.map.apply_transpose(c.forces, Q);
    double work = 0.0, size = 0.0, generalised = 0.0;
    for (int i = 0; i < kPoints; ++i) work += u[i].dot(c.forces[i]), size += u[i].norm() * c.forces[i].norm();
    for (std::size_t i = 0; i < Q.size(); ++i) generalised += c.v[i] * Q[i];
    EXPECT_NEAR(work, generalised, 1e-13 * size);
  });
}

TEST(TreeMap, VelocityIsTheDerivativeOfThePositions) {
  for_trees([](Case& c) {
    const double e = 1e-6;
    const auto up = c.placed(c.moved(e)), down = c.placed(c.moved(-e));
    std::vector<Vec3> u(kPoints);
    c.map.apply(c.v, u);
    for (int i = 0; i < kPoints; ++i)
      EXPECT_LT((u[i] - (up[i] - down[i]) / (2 * e)).norm(), 1e-8 * (1.0 + u[i].norm()));
  });
}

TEST(TreeMap, GeometricTermIsTheChangeOfTheGeneralisedForceWhenTheTreeMoves) {
  double size = 0.0;
  for_trees([&](Case& c) {
    const double e = 1e-6;
    std::vector<double> geometric(c.v.size(), 0.0), up(c.v.size(), 0.0), down(c.v.size(), 0.0);
    c.map.add_geometric(c.forces, c.v, geometric);
    for (const double s : {e, -e}) {
      const TreePose p = c.moved(s);
      TreeMap m;
      m.reset(c.tree, p, c.link, c.placed(p), nullptr);
      m.apply_transpose(c.forces, s > 0 ? up : down);
    }
    double scale = 1.0;
    for (const double g : geometric) scale += std::abs(g);
    for (std::size_t i = 0; i < geometric.size(); ++i)
      EXPECT_NEAR(geometric[i], (up[i] - down[i]) / (2 * e), 1e-8 * scale);
    size += scale;
  });
  EXPECT_GT(size, 100.0);
}

TEST(TreeMap, BlockDiagonalEqualsTheAssembledProductAndTheLinksShareMakesAllOfIt) {
  for_trees([](Case& c) {
    TreeContact contact;
    contact.inertia.assign(c.tree.size(), Mat6::Zero());
    c.map.reset(c.tree, c.pose, c.link, c.points, &contact);
    const auto nv = static_cast<long>(c.v.size());
    Eigen::MatrixXd J(3 * kPoints, nv), big = Eigen::MatrixXd::Zero(3 * kPoints, 3 * kPoints);
    std::vector<Mat3> K;
    for (int i = 0; i < kPoints; ++i) {
      Mat3 m;
      m << c.noise.vec(), c.noise.vec(), c.noise.vec();
      K.push_back(m * m.transpose());
      big.block<3, 3>(3 * i, 3 * i) = K.back();
    }
    std::vector<Vec3> u(kPoints);
    for (long col = 0; col < nv; ++col) {
      std::vector<double> unit(c.v.size(), 0.0);
      unit[col] = 1.0;
      c.map.apply(unit, u);
      for (int i = 0; i < kPoints; ++i) J.col(col).segment<3>(3 * i) = u[i];
    }
    const Eigen::MatrixXd JKJ = J.transpose() * big * J;
    BlockDiagonal D;
    std::vector<int> sizes = {2};
    for (const int s : c.tree.block_sizes()) sizes.push_back(s);
    D.reset(sizes);
    c.map.add_block_diagonal(K, 1, D);
    long row = 0;
    for (std::size_t b = 0; b < c.tree.block_sizes().size(); ++b) {
      const int n = c.tree.block_sizes()[b];
      EXPECT_LT((Eigen::MatrixXd(D.block(b + 1)) - JKJ.block(row, row, n, n)).norm(), 1e-12 * JKJ.norm());
      row += n;
    }
    EXPECT_EQ(D.block(0).norm(), 0.0) << "blocks of others are left alone";
    const Eigen::MatrixXd Jl = testing::tree_jacobian(c.tree, c.pose).middleRows<6>(6 * c.link);
    EXPECT_LT((Jl.transpose() * contact.inertia[c.link] * Jl - JKJ).norm(), 1e-12 * JKJ.norm());
  });
}

TEST(TreeMap, ALinkThatIsFixedToTheWorldDoesNotMove) {
  ArticulatedModel m = random_tree(3, false);
  m.links[0].joint.kind = JointKind::Fixed;
  const Tree tree(m);
  TreePose pose;
  std::vector<double> q(tree.q_size(), 0.5), v(tree.v_size(), 1.0), Q(tree.v_size(), 0.0);
  tree.place(q, pose);
  TreeMap map;
  map.reset(tree, pose, 0, std::vector<Vec3>{Vec3(1, 2, 3)}, nullptr);
  std::vector<Vec3> u(1, Vec3(9, 9, 9));
  map.apply(v, u);
  EXPECT_EQ(u[0], Vec3::Zero());
  map.apply_transpose(u, Q);
  EXPECT_EQ(Q, std::vector<double>(Q.size(), 0.0));
}

}  // namespace
}  // namespace brim::tree_map_test
