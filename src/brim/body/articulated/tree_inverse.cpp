#include "brim/body/articulated/tree_inverse.h"

#include "brim/math/small_symmetric.h"

namespace brim {

bool TreeInverse::factor(const Tree& tree, const TreePose& pose, std::span<const Mat3> T, std::span<const Mat6> W) {
  tree_ = &tree, pose_ = &pose;
  const auto links = tree.links();
  joint_.resize(links.size());
  inertia_.resize(links.size());
  for (std::size_t i = 0; i < links.size(); ++i) {
    inertia_[i] = spatial_inertia(links[i].mass, pose.link[i].center, pose.link[i].inertia);
    if (!W.empty()) inertia_[i] += W[i];
  }
  bool definite = true;
  for (std::size_t i = links.size(); i-- > 0;) {
    Mat6& I = inertia_[i];
    with_dof(links[i].dof, [&](auto k) {
      using Block = Eigen::Matrix<double, k, k>;
      const auto S = pose.link[i].S.template leftCols<k>();
      const Eigen::Matrix<double, 6, k> IS = I * S;
      Block D = S.transpose() * IS;
      joint_[i].pivot = D.trace() / k + links[i].armature;
      D.diagonal().array() += links[i].armature;
      if constexpr (k <= 3) D += T[i].template topLeftCorner<k, k>();
      SmallMatrix any = D;
      // A pivot lost to rounding means that a joint moves nothing.
      definite = invert_definite(any) > 1e-13 && definite;
      const Block inverse = any.topLeftCorner<k, k>();
      joint_[i].inverse.template topLeftCorner<k, k>() = inverse;
      joint_[i].gain.template leftCols<k>() = IS * inverse;
      I.noalias() -= joint_[i].gain.template leftCols<k>() * IS.transpose();
    });
    if (links[i].parent >= 0) inertia_[links[i].parent] += moved_inertia(I, pose.link[i].arm);
  }
  return definite;
}

void TreeInverse::solve(std::span<const double> r, std::span<Vec6> p, std::span<double> x) const {
  const auto links = tree_->links();
  for (std::size_t i = 0; i < links.size(); ++i) p[i].setZero();
  // Inwards: what each joint's load leaves for its parent.
  for (std::size_t i = links.size(); i-- > 0;) {
    const auto& l = links[i];
    const TreePose::Link& pose = pose_->link[i];
    with_dof(l.dof, [&](auto k) {
      using Vector = Eigen::Matrix<double, k, 1>;
      const Vector u = Eigen::Map<const Vector>(r.data() + l.v0) - pose.S.template leftCols<k>().transpose() * p[i];
      Eigen::Map<Vector>(x.data() + l.v0) = joint_[i].inverse.template topLeftCorner<k, k>() * u;
      p[i].noalias() += joint_[i].gain.template leftCols<k>() * u;
    });
    if (l.parent < 0) continue;
    p[l.parent] += p[i];
    p[l.parent].template tail<3>() += pose.arm.cross(Vec3(p[i].template head<3>()));
  }
  // Outwards: the motion, p now twists.
  for (std::size_t i = 0; i < links.size(); ++i) {
    const auto& l = links[i];
    const TreePose::Link& pose = pose_->link[i];
    p[i].setZero();
    if (l.parent >= 0) p[i] = moved_twist(p[l.parent], pose.arm);
    with_dof(l.dof, [&](auto k) {
      Eigen::Map<Eigen::Matrix<double, k, 1>> joint(x.data() + l.v0);
      joint.noalias() -= joint_[i].gain.template leftCols<k>().transpose() * p[i];
      p[i].noalias() += pose.S.template leftCols<k>() * joint;
    });
  }
}

}  // namespace brim
