#include "brim/response/fitting_solids.h"

#include <algorithm>
#include <array>
#include <vector>

#include "brim/math/ramp.h"
#include "brim/math/rotation.h"

namespace brim {

namespace {

/// Largest ratio of the gap's curvature to the surfaces', and least curvature of these times h.
constexpr double kFitting = 0.68, kLeastBent = 0.02;
/// Relative size of the part of the moment matrix that keeps it regular.
constexpr double kLeastMoment = 1e-12;

/// Distances of a solid at many points, [m].
class DistanceReader {
 public:
  explicit DistanceReader(std::size_t n) : d_(n) {
    for (auto& x : local_) x.resize(n);
  }
  std::span<const double> at(const KnownDistance& solid, const Pose& pose, std::span<const Vec3> points) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vec3 y = pose.to_local(points[i]);
      for (int r = 0; r < 3; ++r) local_[r][i] = y[r];
    }
    solid.distances({local_[0].data(), local_[1].data(), local_[2].data(), static_cast<int>(points.size())}, d_.data());
    return d_;
  }

 private:
  std::array<std::vector<double>, 3> local_;
  std::vector<double> d_;
};

}  // namespace

bool fit_each_other(const ContactSet& contacts, const ContactPair& pair) {
  double gap = 0.0, surfaces = 0.0, slopes = 0.0;
  for (std::size_t c = pair.begin; c < pair.end; ++c) {
    const double slope = 0.5 * (contacts.gradient_a[c] - contacts.gradient_b[c]).norm();
    const Mat3 a = contacts.curvature_a(c), b = contacts.curvature_b(c);
    gap += (a + b).norm(), surfaces += 0.5 * (a.norm() + b.norm()), slopes += slope;
  }
  return gap < 2.0 * kFitting * surfaces && surfaces * pair.h > kLeastBent * slopes;
}

Pose SolidMotion::after(const Pose& now, double dt) const {
  const Mat3 turn = rotation_from_vector(dt * spin).toRotationMatrix();
  return {turn * now.rotation, center + dt * velocity + turn * (now.translation - center)};
}

SolidMotion rigid_motion_of(std::span<const Vec3> points, std::span<const Vec3> velocities, const Vec3& mean_velocity) {
  Vec3 middle = Vec3::Zero(), mean = Vec3::Zero(), moment = Vec3::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) middle += points[i], mean += velocities[i];
  const double n = static_cast<double>(std::max<std::size_t>(1, points.size()));
  middle /= n, mean /= n;
  Mat3 inertia = Mat3::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 r = points[i] - middle;
    inertia += r.squaredNorm() * Mat3::Identity() - r * r.transpose();
    moment += r.cross(velocities[i] - mean);
  }
  SolidMotion m;
  m.center = middle, m.velocity = mean;
  if (!(inertia.trace() > 0.0)) return m;
  inertia += kLeastMoment * inertia.trace() * Mat3::Identity();
  m.spin = inertia.ldlt().solve(moment);
  // ω × (center − middle) = mean_velocity − mean, as far as it can be.
  const double square = m.spin.squaredNorm();
  if (square > 0.0) {
    const Vec3 shift = (mean_velocity - mean).cross(m.spin) / square;
    m.center += shift, m.velocity += m.spin.cross(shift);
  }
  return m;
}

void set_rates_by_motion(const ContactSet& contacts, const ContactPair& pair, const CubeSide& a, const CubeSide& b,
                         const SolidMotion& motion_a, const SolidMotion& motion_b, const Vec3& patch, double dt,
                         std::span<double> rate) {
  const std::size_t n = pair.end - pair.begin;
  std::vector<Vec3> now(n), then(n);
  for (std::size_t i = 0; i < n; ++i) {
    now[i] = contacts.node_at(pair.begin + i, pair.h);
    then[i] = now[i] + dt * patch;
  }
  std::fill(rate.begin(), rate.end(), 0.0);
  DistanceReader reader(n);
  const auto add = [&](const CubeSide& side, const Pose& pose, std::span<const Vec3> points, double sign) {
    const std::span<const double> d = reader.at(*side.solid, pose, points);
    for (std::size_t i = 0; i < n; ++i) rate[i] += sign / dt * ramp(d[i], pair.w);
  };
  add(a, a.pose, now, 1.0), add(b, b.pose, now, 1.0);
  add(a, motion_a.after(a.pose, dt), then, -1.0), add(b, motion_b.after(b.pose, dt), then, -1.0);
}

}  // namespace brim
