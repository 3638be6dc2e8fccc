#include "brim/map/rigid_map.h"

namespace brim {

void RigidMap::reset(std::size_t first, const Vec3& origin, std::span<const Vec3> points) {
  first_ = first;
  arm_.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) arm_[i] = points[i] - origin;
}

void RigidMap::apply(std::span<const double> v, std::span<Vec3> u) const {
  const Eigen::Map<const Vec3> o(v.data() + first_), w(v.data() + first_ + 3);
  const Vec3 linear = o, angular = w;
  for (std::size_t i = 0; i < arm_.size(); ++i) u[i] = linear + angular.cross(arm_[i]);
}

void RigidMap::apply_transpose(std::span<const Vec3> f, std::span<double> Q) const {
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  for (std::size_t i = 0; i < arm_.size(); ++i) {
    force += f[i];
    torque += arm_[i].cross(f[i]);
  }
  Eigen::Map<Vec3>(Q.data() + first_) += force;
  Eigen::Map<Vec3>(Q.data() + first_ + 3) += torque;
}

void RigidMap::add_geometric(std::span<const Vec3> f, std::span<const double> dq, std::span<double> Q) const {
  const Eigen::Map<const Vec3> w(dq.data() + first_ + 3);
  const Vec3 turn = w;
  Vec3 torque = Vec3::Zero();
  for (std::size_t i = 0; i < arm_.size(); ++i) torque += turn.cross(arm_[i]).cross(f[i]);
  Eigen::Map<Vec3>(Q.data() + first_ + 3) += torque;
}

bool RigidMap::append_rows(MapRows& out) const {
  if (first_ % 3 != 0) return false;
  const auto column = static_cast<std::int32_t>(first_ / 3);
  for (const Vec3& arm : arm_) {
    out.add(column, 1.0f);
    out.add(column + 1, Eigen::Matrix3f(-skew(arm).cast<float>()));
    out.end_row();
  }
  return true;
}

void RigidMap::add_block_diagonal(std::span<const Mat3> K, std::size_t first, BlockDiagonal& D) const {
  Eigen::Matrix<double, 6, 6> sum = Eigen::Matrix<double, 6, 6>::Zero();
  for (std::size_t i = 0; i < arm_.size(); ++i) {
    const Mat3 X = skew(arm_[i]);  // u = o' − X ω
    const Mat3 KX = K[i] * X;
    sum.topLeftCorner<3, 3>() += K[i];
    sum.topRightCorner<3, 3>() -= KX;
    sum.bottomRightCorner<3, 3>() += X.transpose() * KX;
  }
  sum.bottomLeftCorner<3, 3>() = sum.topRightCorner<3, 3>().transpose();
  D.block(first) += sum;
}

}  // namespace brim
