#pragma once

#include <random>

#include "brim/body/articulated/tree.h"
#include "brim/math/rotation.h"

/// Trees of links, and matrices that say what their recursions must give.
namespace brim::testing {

class TreeNoise {
 public:
  explicit TreeNoise(unsigned seed) : rng_(seed) {}
  double operator()() { return normal_(rng_); }
  Vec3 vec() {
    const double x = normal_(rng_), y = normal_(rng_);
    return {x, y, normal_(rng_)};
  }
  std::vector<double> list(std::size_t n) {
    std::vector<double> x(n);
    for (double& e : x) e = normal_(rng_);
    return x;
  }

 private:
  std::mt19937 rng_;
  std::normal_distribution<double> normal_;
};

/// Links of every joint kind, with branches, offset frames and skew inertia.
inline ArticulatedModel random_tree(unsigned seed, bool floating, int links = 9) {
  TreeNoise noise(seed);
  ArticulatedModel model;
  constexpr JointKind kKinds[] = {JointKind::Revolute, JointKind::Ball, JointKind::Prismatic, JointKind::Fixed};
  for (int i = 0; i < links; ++i) {
    LinkModel l;
    l.name = "link" + std::to_string(i);
    l.parent = i == 0 ? -1 : (i % 3 == 0 ? i / 2 : i - 1);
    l.joint.kind = i == 0 && floating ? JointKind::Free : kKinds[(i + seed) % 4];
    l.joint.position = noise.vec();
    l.joint.rotation = rotation_from_vector(noise.vec());
    l.joint.axis = noise.vec();
    l.joint.armature = i % 4 == 1 ? 0.3 : 0.0;
    l.joint.start = noise();
    l.joint.start_velocity = noise();
    l.joint.start_rotation = rotation_from_vector(noise.vec());
    l.joint.velocity = noise.vec(), l.joint.angular_velocity = noise.vec();
    l.mass = 0.5 + std::abs(noise());
    l.center_of_mass = 0.5 * noise.vec();
    Mat3 m;
    m << noise.vec(), noise.vec(), noise.vec();
    l.inertia = 0.2 * m * m.transpose() + 0.1 * Mat3::Identity();
    model.links.push_back(l);
  }
  return model;
}

/// Twist of every link at its origin per unit of every joint velocity, shape (6 links, nv), from Tree::twists.
inline Eigen::MatrixXd tree_jacobian(const Tree& tree, const TreePose& pose) {
  Eigen::MatrixXd J(6 * tree.size(), tree.v_size());
  std::vector<Vec6> V(tree.size());
  for (std::size_t c = 0; c < tree.v_size(); ++c) {
    std::vector<double> unit(tree.v_size(), 0.0);
    unit[c] = 1.0;
    tree.twists(pose, unit, V);
    for (std::size_t i = 0; i < V.size(); ++i) J.block<6, 1>(6 * i, c) = V[i];
  }
  return J;
}

/// M by its definition, Σ Jᵀ I J and armature.
inline Eigen::MatrixXd mass_matrix(const Tree& tree, const TreePose& pose) {
  const Eigen::MatrixXd J = tree_jacobian(tree, pose);
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(J.cols(), J.cols());
  for (std::size_t i = 0; i < tree.size(); ++i) {
    const auto Ji = J.middleRows<6>(6 * i);
    M += Ji.transpose() * spatial_inertia(tree.links()[i].mass, pose.link[i].center, pose.link[i].inertia) * Ji;
    for (int k = 0; k < tree.links()[i].dof; ++k)
      M(tree.links()[i].v0 + k, tree.links()[i].v0 + k) += tree.links()[i].armature;
  }
  return M;
}

}  // namespace brim::testing
