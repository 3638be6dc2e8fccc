#include "brim/body/rigid/rigid_body.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "brim/core/error.h"
#include "brim/map/rigid_map.h"
#include "brim/math/free_turn.h"
#include "brim/math/small_symmetric.h"

namespace brim {

namespace {

/// Rounding of an inertia that is that of a thin plate, relative.
constexpr double kTriangle = 1e-6;

void need_finite(const char* what, const Vec3& x) {
  if (!x.allFinite())
    throw InputError(fmt::format("rigid body: {} is ({}, {}, {}); must be finite", what, x.x(), x.y(), x.z()));
}

void need_damping(const char* what, double value) {
  if (!(value >= 0.0) || !std::isfinite(value))
    throw InputError(fmt::format("rigid body: {} is {}; must be a number from 0 [1/s]", what, value));
}

/// Of any masses, no principal moment is larger than the sum of the other two.
void need_inertia(const Mat3& inertia) {
  if (!inertia.allFinite()) throw InputError("rigid body: the inertia tensor is not finite");
  if (!inertia.isApprox(inertia.transpose(), 1e-9)) throw InputError("rigid body: the inertia tensor is not symmetric");
  Vec3 moments = symmetric_axes(inertia).values;
  std::ranges::sort(moments.reshaped());
  const std::string found = fmt::format("{:.6g}, {:.6g} and {:.6g} kg m²", moments[0], moments[1], moments[2]);
  if (!(moments[0] > 0.0))
    throw InputError(
        fmt::format("rigid body: the inertia tensor is not positive definite, with principal moments {}; is the solid "
                    "closed and not empty?",
                    found));
  if (moments[2] > (1.0 + kTriangle) * (moments[0] + moments[1]))
    throw InputError(
        fmt::format("rigid body: no solid has the principal moments {}; the largest may be at most the "
                    "sum of the others",
                    found));
}

}  // namespace

RigidBody::RigidBody(RigidModel model)
    : model_(std::move(model)), solid_(std::move(model_.shape), std::move(model_.surface)) {
  if (!(model_.mass > 0.0) || !std::isfinite(model_.mass))
    throw InputError(fmt::format("rigid body: mass is {}, but must be positive and finite [kg]", model_.mass));
  need_inertia(model_.inertia);
  need_finite("the centre of mass", model_.center_of_mass);
  need_finite("the position", model_.position);
  need_finite("the velocity", model_.velocity);
  need_finite("the angular velocity", model_.angular_velocity);
  need_damping("linear_damping", model_.linear_damping);
  need_damping("angular_damping", model_.angular_damping);
  if (const double length = model_.rotation.coeffs().stableNorm(); !(length > 0.0) || !std::isfinite(length))
    throw InputError(fmt::format("rigid body: the quaternion of the rotation has length {}; must be near 1", length));
  model_inverse_ = model_.inertia.llt().solve(Mat3::Identity());
  reach_ = solid_.reach(model_.center_of_mass);
  display_.vertices = solid_.surface().vertices.size();
  display_.triangles = solid_.triangles();
}

void RigidBody::initial_state(std::span<double> q, std::span<double> v) const {
  const Quat r = model_.rotation.normalized();
  Eigen::Map<Vec3>(q.data()) = model_.position + r * model_.center_of_mass;
  q[3] = r.w(), q[4] = r.x(), q[5] = r.y(), q[6] = r.z();
  Eigen::Map<Vec3>(v.data()) = model_.velocity;
  Eigen::Map<Vec3>(v.data() + 3) = model_.angular_velocity;
}

void RigidBody::update(double, std::span<const double> q, std::span<const double> v) {
  center_ = Vec3(q[0], q[1], q[2]);
  const Mat3 R = Quat(q[3], q[4], q[5], q[6]).toRotationMatrix();
  solid_.place({R, center_ - R * model_.center_of_mass});
  inertia_ = R * model_.inertia * R.transpose();
  inverse_inertia_ = R * model_inverse_ * R.transpose();
  momentum_rate_ = -model_.linear_damping * model_.mass * Vec3(v[0], v[1], v[2]);
  spin_rate_ = -model_.angular_damping * (inertia_ * Vec3(v[3], v[4], v[5]));
}

void RigidBody::advance(double dt, std::span<double> q, std::span<const double> v) const {
  Eigen::Map<Vec3>(q.data()) += dt * Vec3(v[0], v[1], v[2]);
  // The rotation of a free body: the angular momentum is held, the spin is not.
  const Quat r(q[3], q[4], q[5], q[6]);
  const Mat3 R = r.toRotationMatrix(), inverse = R * model_inverse_ * R.transpose();
  const Vec3 L = R * (model_.inertia * (R.transpose() * Vec3(v[3], v[4], v[5])));
  const Quat next = (free_turn(L, dt, [&](const Vec3& l) -> Vec3 { return inverse * l; }) * r).normalized();
  q[3] = next.w(), q[4] = next.x(), q[5] = next.y(), q[6] = next.z();
}

void RigidBody::finish_step(double, double, std::span<double> q, std::span<double> v) {
  const Vec3 L = inertia_ * Vec3(v[3], v[4], v[5]);
  const Mat3 R = Quat(q[3], q[4], q[5], q[6]).toRotationMatrix();
  const Eigen::LLT<Mat3> inverse(model_.inertia);
  const auto spin_of = [&](const Vec3& momentum) -> Vec3 { return R * inverse.solve(R.transpose() * momentum); };
  // R is orthogonal only to rounding, with a bias that grows over thousands of steps: correct once by what is missing.
  const Mat3 inertia = R * model_.inertia * R.transpose();
  Vec3 w = spin_of(L);
  w += spin_of(L - inertia * w);
  Eigen::Map<Vec3>(v.data() + 3) = w;
}

void RigidBody::add_forces(const Environment& env, std::span<double> Q) const {
  Eigen::Map<Vec3>(Q.data()) += model_.mass * env.gravity + momentum_rate_;
  Eigen::Map<Vec3>(Q.data() + 3) += spin_rate_;
  add_outer_forces(Q);
}

void RigidBody::apply_mass(std::span<const double> x, std::span<double> y) const {
  Eigen::Map<Vec3>(y.data()) += model_.mass * Vec3(x[0], x[1], x[2]);
  Eigen::Map<Vec3>(y.data() + 3) += inertia_ * Vec3(x[3], x[4], x[5]);
}

void RigidBody::apply_damping(std::span<const double> x, std::span<double> y) const {
  Eigen::Map<Vec3>(y.data()) -= model_.linear_damping * model_.mass * Vec3(x[0], x[1], x[2]);
  Eigen::Map<Vec3>(y.data() + 3) -= model_.angular_damping * (inertia_ * Vec3(x[3], x[4], x[5]));
}

void RigidBody::apply_system(std::span<const double> x, std::span<double> y) const {
  Eigen::Map<Vec3>(y.data()) += (1.0 + dt_ * model_.linear_damping) * model_.mass * Vec3(x[0], x[1], x[2]);
  Eigen::Map<Vec3>(y.data() + 3) += (1.0 + dt_ * model_.angular_damping) * (inertia_ * Vec3(x[3], x[4], x[5]));
}

void RigidBody::add_system_diagonal(std::size_t first, BlockDiagonal& D) const {
  auto block = D.block(first);
  block.topLeftCorner<3, 3>() += (1.0 + dt_ * model_.linear_damping) * model_.mass * Mat3::Identity();
  block.bottomRightCorner<3, 3>() += (1.0 + dt_ * model_.angular_damping) * inertia_;
}

double RigidBody::relative_speed_bound(int, std::span<const double> v) const {
  return reach_ * Vec3(v[3], v[4], v[5]).norm();
}

void RigidBody::make_map(int, std::span<const Vec3> points, std::span<const std::int32_t>,
                         std::unique_ptr<Map>& map) const {
  if (!map) map = std::make_unique<RigidMap>();
  static_cast<RigidMap&>(*map).reset(0, center_, points);
}

double RigidBody::potential_energy(const Environment& env) const { return -model_.mass * env.gravity.dot(center_); }

Vec3 RigidBody::linear_momentum(std::span<const double> v) const { return model_.mass * Vec3(v[0], v[1], v[2]); }

Vec3 RigidBody::angular_momentum(std::span<const double> v) const {
  return center_.cross(linear_momentum(v)) + inertia_ * Vec3(v[3], v[4], v[5]);
}

RigidFrame::Frame RigidBody::rigid_frame() const {
  return {center_, 1.0 / ((1.0 + dt_ * model_.linear_damping) * model_.mass),
          inverse_inertia_ / (1.0 + dt_ * model_.angular_damping)};
}

bool RigidBody::rigid_motion(const Vec3& t, const Vec3& w, std::span<double> v) const {
  Eigen::Map<Vec3>(v.data()) = t + w.cross(center_);
  Eigen::Map<Vec3>(v.data() + 3) = w;
  return true;
}

}  // namespace brim
