#include "brim/body/articulated/tree_map.h"

#include <algorithm>

namespace brim {

void TreeMap::reset(const Tree& tree, const TreePose& pose, int link, std::span<const Vec3> points,
                    TreeContact* contact) {
  link_ = link;
  contact_ = contact;
  const Vec3 o = pose.link[link].origin;
  joint_.clear();
  for (int i = link; i >= 0; i = tree.links()[i].parent) {
    const Tree::Link& l = tree.links()[i];
    if (l.dof > 0) joint_.push_back({l.v0, i, l.dof, l.block, pose.link[i].origin - o});
  }
  std::reverse(joint_.begin(), joint_.end());
  int columns = 0;
  for (const Joint& j : joint_) columns += j.dof;
  J_.resize(6, columns);
  columns = 0;
  for (Joint& j : joint_) {
    const int i = j.column;  // so far the link's number
    j.column = columns;
    for (int k = 0; k < j.dof; ++k) J_.col(columns++) = moved_twist(pose.link[i].S.col(k), -j.offset);
  }
  arm_.resize(points.size());
  for (std::size_t p = 0; p < points.size(); ++p) arm_[p] = points[p] - o;
}

Vec6 TreeMap::twist(std::span<const double> v) const {
  Vec6 V = Vec6::Zero();
  for (const Joint& j : joint_)
    for (int k = 0; k < j.dof; ++k) V += v[j.v0 + k] * J_.col(j.column + k);
  return V;
}

void TreeMap::apply(std::span<const double> v, std::span<Vec3> u) const {
  const Vec6 V = twist(v);
  const Vec3 linear = V.head<3>(), angular = V.tail<3>();
  for (std::size_t i = 0; i < arm_.size(); ++i) u[i] = linear + angular.cross(arm_[i]);
}

void TreeMap::apply_transpose(std::span<const Vec3> f, std::span<double> Q) const {
  Vec6 W = Vec6::Zero();
  for (std::size_t i = 0; i < arm_.size(); ++i) {
    W.head<3>() += f[i];
    W.tail<3>() += arm_[i].cross(f[i]);
  }
  for (const Joint& j : joint_)
    for (int k = 0; k < j.dof; ++k) Q[j.v0 + k] += J_.col(j.column + k).dot(W);
}

void TreeMap::add_geometric(std::span<const Vec3> f, std::span<const double> dq, std::span<double> Q) const {
  const Vec6 V = twist(dq);
  const Vec3 linear = V.head<3>(), angular = V.tail<3>();
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero(), torque_change = Vec3::Zero();  // about the link's origin
  for (std::size_t i = 0; i < arm_.size(); ++i) {
    force += f[i];
    torque += arm_[i].cross(f[i]);
    torque_change += (linear + angular.cross(arm_[i])).cross(f[i]);
  }
  Vec6 moved = Vec6::Zero();  // of the parent, then of the link that the joint carries; at the map's origin
  for (const Joint& j : joint_) {
    const Vec3 turn = moved.tail<3>();
    for (int k = 0; k < j.dof; ++k) moved += dq[j.v0 + k] * J_.col(j.column + k);
    const Vec3 origin_moves = moved_twist(moved, j.offset).head<3>();
    const Vec3 about = torque - j.offset.cross(force);  // torque about the joint's own origin, and its change
    const Vec3 change = torque_change - origin_moves.cross(force);
    for (int k = 0; k < j.dof; ++k) {
      const Vec6 S = moved_twist(J_.col(j.column + k), j.offset);
      const Vec3 slide = S.head<3>(), axis = S.tail<3>();
      Q[j.v0 + k] += turn.cross(axis).dot(about) + axis.dot(change) + turn.cross(slide).dot(force);
    }
  }
}

void TreeMap::add_block_diagonal(std::span<const Mat3> K, std::size_t first, BlockDiagonal& D) const {
  Mat6 W = Mat6::Zero();
  for (std::size_t i = 0; i < arm_.size(); ++i) {
    const Mat3 X = skew(arm_[i]);  // u = U − X Ω
    const Mat3 KX = K[i] * X;
    W.topLeftCorner<3, 3>() += K[i];
    W.topRightCorner<3, 3>() -= KX;
    W.bottomRightCorner<3, 3>() += X.transpose() * KX;
  }
  W.bottomLeftCorner<3, 3>() = W.topRightCorner<3, 3>().transpose();
  for (const Joint& j : joint_) {
    const auto columns = J_.middleCols(j.column, j.dof);
    D.block(first + j.block) += columns.transpose() * W * columns;
  }
  if (contact_) contact_->inertia[link_] += W;
}

}  // namespace brim
