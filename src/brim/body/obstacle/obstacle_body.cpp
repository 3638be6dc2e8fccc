#include "brim/body/obstacle/obstacle_body.h"

#include <cmath>

#include "brim/core/error.h"
#include "brim/map/rigid_map.h"
#include "brim/math/rotation.h"

namespace brim {

namespace {

/// Pose at a time: linear and spherical between keys, held before the first and after the last.
PoseKey pose_at(const std::vector<PoseKey>& keys, double time) {
  if (time <= keys.front().time) return keys.front();
  if (time >= keys.back().time) return keys.back();
  std::size_t i = 1;
  while (keys[i].time < time) ++i;
  const PoseKey &a = keys[i - 1], &b = keys[i];
  const double s = (time - a.time) / (b.time - a.time);
  return {time, (1.0 - s) * a.position + s * b.position, a.rotation.slerp(s, b.rotation).normalized()};
}

}  // namespace

ObstacleBody::ObstacleBody(ObstacleModel model)
    : model_(std::move(model)), solid_(std::move(model_.shape), std::move(model_.surface)) {
  if (model_.keys.empty()) throw InputError("obstacle: at least one pose is needed");
  for (std::size_t i = 1; i < model_.keys.size(); ++i)
    if (!(model_.keys[i].time > model_.keys[i - 1].time))
      throw InputError(fmt::format("obstacle: key {} has time {}, but times must increase (previous {})", i,
                                   model_.keys[i].time, model_.keys[i - 1].time));
  for (PoseKey& k : model_.keys) {
    const double length = k.rotation.coeffs().stableNorm();
    if (!std::isfinite(k.time) || !k.position.allFinite() || !(length > 0.0) || !std::isfinite(length))
      throw InputError(fmt::format(
          "obstacle: the pose at time {} has the position ({}, {}, {}) and a quaternion of length {}; all must be "
          "finite, and the length near 1",
          k.time, k.position.x(), k.position.y(), k.position.z(), length));
    k.rotation.normalize();
  }
  reach_ = solid_.box_reach(Vec3::Zero());
  display_.vertices = solid_.surface().vertices.size();
  display_.triangles = solid_.triangles();
}

void ObstacleBody::initial_state(std::span<double> q, std::span<double> v) const {
  const PoseKey k = pose_at(model_.keys, 0.0);
  Eigen::Map<Vec3>(q.data()) = k.position;
  q[3] = k.rotation.w(), q[4] = k.rotation.x(), q[5] = k.rotation.y(), q[6] = k.rotation.z();
  std::fill(v.begin(), v.end(), 0.0);
}

void ObstacleBody::prescribe(double time, double dt, std::span<const double> q, std::span<double> v) const {
  if (motion_ && !motion_->to_pose) {
    Eigen::Map<Vec3>(v.data()) = motion_->velocity, Eigen::Map<Vec3>(v.data() + 3) = motion_->spin;
    return;
  }
  // A target that was reached is held.
  const bool moves = motion_ ? motion_->at - time > 1e-9 * dt : animated();
  if (!moves || !(dt > 0.0)) {
    std::fill(v.begin(), v.end(), 0.0);
    return;
  }
  const PoseKey next = motion_ ? PoseKey{time, motion_->position, motion_->rotation} : pose_at(model_.keys, time + dt);
  if (motion_) dt = std::max(dt, motion_->at - time);
  Eigen::Map<Vec3>(v.data()) = (next.position - Vec3(q[0], q[1], q[2])) / dt;
  const Quat now(q[3], q[4], q[5], q[6]);
  Eigen::Map<Vec3>(v.data() + 3) = vector_from_rotation(next.rotation * now.conjugate()) / dt;
}

void ObstacleBody::update(double, std::span<const double> q, std::span<const double>) {
  solid_.place({Quat(q[3], q[4], q[5], q[6]).toRotationMatrix(), Vec3(q[0], q[1], q[2])});
}

void ObstacleBody::advance(double dt, std::span<double> q, std::span<const double> v) const {
  if (!animated() && !motion_) return;
  Eigen::Map<Vec3>(q.data()) += dt * Vec3(v[0], v[1], v[2]);
  const Quat next = (rotation_from_vector(dt * Vec3(v[3], v[4], v[5])) * Quat(q[3], q[4], q[5], q[6])).normalized();
  q[3] = next.w(), q[4] = next.x(), q[5] = next.y(), q[6] = next.z();
}

void ObstacleBody::apply_mass(std::span<const double> x, std::span<double> y) const {
  for (std::size_t i = 0; i < x.size(); ++i) y[i] += x[i];  // any definite matrix: the filter removes it
}

void ObstacleBody::add_system_diagonal(std::size_t first, BlockDiagonal& D) const {
  D.block(first) += Eigen::Matrix<double, 6, 6>::Identity();
}

double ObstacleBody::relative_speed_bound(int, std::span<const double> v) const {
  return reach_ * Vec3(v[3], v[4], v[5]).norm();
}

void ObstacleBody::make_map(int, std::span<const Vec3> points, std::span<const std::int32_t>,
                            std::unique_ptr<Map>& map) const {
  if (!map) map = std::make_unique<RigidMap>();
  static_cast<RigidMap&>(*map).reset(0, solid_.pose().translation, points);
}

}  // namespace brim
