#include "brim/solve/rigid_pair_rows.h"

#include <algorithm>

#include "brim/solve/contact_cone.h"

namespace brim {

namespace {

struct Twist {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
};

Mat3 doubles(const Eigen::Matrix3f& m) { return m.cast<double>(); }

/// Velocity at x0 and spin of one side. @param arm  x0 − c
Twist twist_of(const RigidPairRows::Side& s, const Vec3& arm, std::span<const double> v) {
  if (s.first == RigidPairRows::kFixed) return {};
  const Eigen::Map<const Vec3> o(v.data() + s.first), w(v.data() + s.first + 3);
  return {o + w.cross(arm), w};
}

/// Response of one side's twist at x0 to a force and a torque there.
Twist response_of(const RigidPairRows::Side& s, const Vec3& arm, const Vec3& force, const Vec3& torque) {
  const Vec3 spin = s.inverse_inertia * (torque + arm.cross(force));
  return {s.inverse_mass * force + spin.cross(arm), spin};
}

}  // namespace

void RigidPairRows::clear() { pair_.clear(), row_.clear(); }

void RigidPairRows::add(const Side& a, const Side& b, std::span<const Vec3> points, std::span<const Vec3> grips,
                        std::span<const Mat3> frames, double friction) {
  Vec3 x0 = Vec3::Zero();
  for (const Vec3& x : points) x0 += x / static_cast<double>(points.size());
  const Pair pair{a, b, x0 - a.center, x0 - b.center, friction, row_.size(), row_.size() + points.size()};
  for (std::size_t i = 0; i < points.size(); ++i) {
    Row r;
    r.frame = frames[i], r.pair = static_cast<std::uint32_t>(pair_.size());
    for (int k = 0; k < 3; ++k)
      r.lever.row(k) = ((k == 0 ? points[i] : grips[i]) - x0).cross(frames[i].row(k).transpose()).transpose();
    set_responses(pair, r);
    row_.push_back(r);
  }
  pair_.push_back(pair);
}

void RigidPairRows::set_responses(const Pair& p, Row& r) {
  Eigen::Matrix<double, 6, 3> twist;
  for (int k = 0; k < 3; ++k) {
    const Vec3 f = r.frame.row(k).transpose(), torque = r.lever.row(k).transpose();
    const Twist by_a = response_of(p.a, p.arm_a, f, torque), by_b = response_of(p.b, p.arm_b, f, torque);
    twist.col(k) << by_a.linear + by_b.linear, by_a.angular + by_b.angular;
  }
  Mat3 local = r.frame * twist.topRows<3>() + r.lever * twist.bottomRows<3>();
  local = 0.5 * (local + local.transpose()).eval();
  r.twist = twist.cast<float>(), r.local = local.cast<float>(), r.local_inverse = invert_response(local).cast<float>();
}

void RigidPairRows::move_friction(std::size_t i, const Vec3& way, const Vec3& impulse, std::span<double> v) {
  Row& r = row_[i];
  Vec3 torque = Vec3::Zero();
  for (int k = 1; k < 3; ++k) {
    const Vec3 more = way.cross(Vec3(r.frame.row(k).transpose()));
    r.lever.row(k) += more.transpose();
    torque += impulse[k] * more;
  }
  set_responses(pair_[r.pair], r);
  add_wrench(pair_[r.pair], Vec3::Zero(), torque, v);
}

Vec3 RigidPairRows::velocity(std::size_t i, std::span<const double> v) const {
  const Row& r = row_[i];
  const Pair& p = pair_[r.pair];
  const Twist a = twist_of(p.a, p.arm_a, v), b = twist_of(p.b, p.arm_b, v);
  return r.frame * (a.linear - b.linear) + r.lever * (a.angular - b.angular);
}

void RigidPairRows::add_wrench(const Pair& p, const Vec3& force, const Vec3& torque, std::span<double> v) {
  const auto add = [&](const Side& s, const Vec3& arm, double sign) {
    if (s.first == kFixed) return;
    Eigen::Map<Vec3>(v.data() + s.first) += sign * s.inverse_mass * force;
    Eigen::Map<Vec3>(v.data() + s.first + 3) += sign * (s.inverse_inertia * (torque + arm.cross(force)));
  };
  add(p.a, p.arm_a, 1.0);
  add(p.b, p.arm_b, -1.0);
}

void RigidPairRows::add_response(std::size_t i, const Vec3& impulse, std::span<double> v) const {
  const Row& r = row_[i];
  add_wrench(pair_[r.pair], r.frame.transpose() * impulse, r.lever.transpose() * impulse, v);
}

void RigidPairRows::add_force(std::size_t i, const Vec3& impulse, std::span<double> Q) const {
  const Row& r = row_[i];
  const Pair& p = pair_[r.pair];
  const Vec3 force = r.frame.transpose() * impulse, torque = r.lever.transpose() * impulse;
  const auto add = [&](const Side& s, const Vec3& arm, double sign) {
    if (s.first == kFixed) return;
    Eigen::Map<Vec3>(Q.data() + s.first) += sign * force;
    Eigen::Map<Vec3>(Q.data() + s.first + 3) += sign * (torque + arm.cross(force));
  };
  add(p.a, p.arm_a, 1.0);
  add(p.b, p.arm_b, -1.0);
}

double RigidPairRows::relax(std::size_t pair, bool backward, int rounds, double friction, std::span<const Vec3> offset,
                            std::span<const double> target, std::span<Vec3> impulse, std::span<double> v) const {
  const Pair& p = pair_[pair];
  const Twist a = twist_of(p.a, p.arm_a, v), b = twist_of(p.b, p.arm_b, v);
  Vec3 linear = a.linear - b.linear, angular = a.angular - b.angular;
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  double worst = 0.0;
  bool changed = false;
  const std::size_t n = p.end - p.begin;
  if (n == 1) rounds = 1;
  for (int round = 0; round < rounds; ++round) {
    bool any = false;
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t i = backward ? n - 1 - k : k;
      const Row& r = row_[p.begin + i];
      if (!(r.local(0, 0) > 0.0)) continue;
      // What carries nothing and parts fast enough stays as it is: most rows of a pile only wait.
      if (impulse[i].x() == 0.0 &&
          r.frame.row(0).dot(linear) + r.lever.row(0).dot(angular) + offset[i].x() >= target[i])
        continue;
      const Mat3 local = doubles(r.local);
      Vec3 u = r.frame * linear + r.lever * angular + offset[i];
      u.x() -= target[i];
      const Vec3 next = relax_contact(local, doubles(r.local_inverse), friction * p.friction, u, impulse[i]);
      const Vec3 change = next - impulse[i];
      if (change == Vec3::Zero()) continue;
      any = true;
      impulse[i] = next;
      if (round == 0) worst = std::max(worst, (local * change).cwiseAbs().maxCoeff());
      force += r.frame.transpose() * change, torque += r.lever.transpose() * change;
      const Eigen::Matrix<double, 6, 3> twist = r.twist.cast<double>();
      linear += twist.topRows<3>() * change, angular += twist.bottomRows<3>() * change;
    }
    if (!any) break;
    changed = true;
  }
  if (changed) add_wrench(p, force, torque, v);
  return worst;
}

}  // namespace brim
