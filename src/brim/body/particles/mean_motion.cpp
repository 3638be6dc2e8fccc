#include "brim/body/particles/mean_motion.h"

#include <algorithm>
#include <cmath>

#include "brim/math/free_turn.h"
#include "brim/math/small_symmetric.h"

namespace brim {

namespace {

/// Prescribed particles within this share of their extent from a line count as on it.
constexpr double kOnLine = 1e-9;

Eigen::Map<const Vec3> triple(std::span<const double> a, std::size_t i) {
  return Eigen::Map<const Vec3>(a.data() + 3 * i);
}
Eigen::Map<Vec3> triple(std::span<double> a, std::size_t i) { return Eigen::Map<Vec3>(a.data() + 3 * i); }

/// Calls f(i) for the particles that are not prescribed.
template <class F>
void for_others(const ParticleSet& p, const F& f) {
  auto given = p.prescribed.begin();
  for (std::size_t i = 0; i < p.mass.size(); ++i) {
    if (given != p.prescribed.end() && static_cast<std::size_t>(*given) == i)
      ++given;
    else
      f(i);
  }
}

/// c, ċ and the axis.
MeanMotion frame_of(const ParticleSet& p, std::span<const double> x, std::span<const double> v) {
  MeanMotion m;
  m.least_inertia = p.least_inertia;
  if (p.prescribed.empty()) {
    double total = 0.0;
    for (std::size_t i = 0; i < p.mass.size(); ++i) {
      total += p.mass[i];
      m.center += p.mass[i] * triple(x, i);
      m.velocity += p.mass[i] * triple(v, i);
    }
    m.center /= total, m.velocity /= total;
    return m;
  }
  const auto first = static_cast<std::size_t>(p.prescribed[0]);
  m.center = triple(x, first), m.velocity = triple(v, first);
  Vec3 along = Vec3::Zero();
  for (const std::int32_t i : p.prescribed) {
    const Vec3 d = triple(x, static_cast<std::size_t>(i)) - m.center;
    if (d.squaredNorm() > along.squaredNorm()) along = d;
    m.free = m.free && triple(v, static_cast<std::size_t>(i)) == m.velocity;
  }
  if (!m.free || along.squaredNorm() == 0.0) return m;
  const double length = along.norm();
  m.axis = along / length;
  for (const std::int32_t i : p.prescribed)
    m.free = m.free && m.axis->cross(triple(x, static_cast<std::size_t>(i)) - m.center).norm() <= kOnLine * length;
  return m;
}

void take_inertia(const ParticleSet& p, std::span<const double> x, MeanMotion& m) {
  Mat3 second = Mat3::Zero();
  for (std::size_t i = 0; i < p.mass.size(); ++i) {
    const Vec3 d = triple(x, i) - m.center;
    second += p.mass[i] * d * d.transpose();
  }
  m.inertia = second.trace() * Mat3::Identity() - second;
}

}  // namespace

namespace {

/// ω of an angular momentum, the axes of inertia known.
Vec3 spin_about(const SymmetricAxes& e, double least_share, const Vec3& L) {
  const double least = least_share * e.values[2];
  Vec3 w = Vec3::Zero();
  for (int k = 0; k < 3; ++k) {
    const double I = e.values[k], mobility = I >= least && I > 0.0 ? 1.0 / I
                                             : least > 0.0         ? std::max(0.0, I) / (least * least)
                                                                   : 0.0;
    w += mobility * e.vectors.col(k).dot(L) * e.vectors.col(k);
  }
  return w;
}

}  // namespace

Vec3 MeanMotion::spin_of(const Vec3& L) const {
  if (axis) {
    const double about = axis->dot(inertia * *axis);
    return about > 0.0 ? Vec3(*axis * (axis->dot(L) / about)) : Vec3::Zero();
  }
  return spin_about(symmetric_axes(inertia), least_inertia, L);
}

Mat3 MeanMotion::turn(double dt) const {
  if (axis) return rotation_from_vector(dt * spin).toRotationMatrix();
  const SymmetricAxes axes = symmetric_axes(inertia);
  return free_turn(inertia * spin, dt, [&](const Vec3& L) { return spin_about(axes, least_inertia, L); })
      .toRotationMatrix();
}

MeanMotion mean_motion(const ParticleSet& p, std::span<const double> x, std::span<const double> v) {
  MeanMotion m = frame_of(p, x, v);
  if (!m.free) return m;
  take_inertia(p, x, m);
  Vec3 L = Vec3::Zero();
  for (std::size_t i = 0; i < p.mass.size(); ++i)
    L += p.mass[i] * (triple(x, i) - m.center).cross(triple(v, i) - m.velocity);
  m.spin = m.spin_of(L), m.momentum = L;
  return m;
}

void advance_turning(const ParticleSet& p, double dt, std::span<double> x, std::span<const double> v,
                     const Straighten& straighten) {
  const MeanMotion m = mean_motion(p, x, v);
  const Mat3 R = m.turn(dt), turned = R - Mat3::Identity();
  const auto own = [&](std::size_t i) { return m.own(triple(x, i), triple(v, i)); };
  std::vector<double> more;
  if (straighten) {
    std::vector<double> way(x.size());
    for (std::size_t i = 0; i < p.mass.size(); ++i) triple(std::span(way), i) = dt * own(i);
    more.assign(x.size(), 0.0);
    if (!straighten(x, way, more)) more.clear();
  }
  const auto extra = [&](std::size_t i) -> Vec3 {
    const Vec3 d = triple(x, i) - m.center;
    return turned * (d + dt * own(i)) - dt * m.spin.cross(d);
  };
  if (m.spin != Vec3::Zero())
    for_others(p, [&](std::size_t i) { triple(x, i) += dt * triple(v, i) + extra(i); });
  else
    for_others(p, [&](std::size_t i) { triple(x, i) += dt * triple(v, i); });
  if (!more.empty()) for_others(p, [&](std::size_t i) { triple(x, i) += R * triple(std::span(more), i); });
  for (const std::int32_t i : p.prescribed) {
    const auto k = static_cast<std::size_t>(i);
    triple(x, k) += dt * triple(v, k);
  }
}

void add_turning_forces(const ParticleSet& p, double dt, std::span<const double> x, std::span<const double> v,
                        std::span<double> Q) {
  const MeanMotion m = mean_motion(p, x, v);
  if (!(dt > 0.0) || m.spin == Vec3::Zero()) return;
  const Mat3 back = m.turn(-dt), round_part = back - Mat3::Identity(), own_part = back * back - Mat3::Identity();
  const auto change = [&](std::size_t i, const Vec3& d) -> Vec3 {
    const Vec3 round = m.spin.cross(d);
    return round_part * round + own_part * (triple(v, i) - m.velocity - round);
  };
  Vec3 mean = Vec3::Zero(), L = Vec3::Zero();
  double total = 0.0;
  for (std::size_t i = 0; i < p.mass.size(); ++i) {
    const Vec3 d = triple(x, i) - m.center, c = p.mass[i] * change(i, d);
    mean += c, L += d.cross(c), total += p.mass[i];
  }
  mean = p.prescribed.empty() ? Vec3(mean / total) : Vec3::Zero();
  const Vec3 w = m.spin_of(L);
  for_others(p, [&](std::size_t i) {
    const Vec3 d = triple(x, i) - m.center;
    triple(Q, i) += p.mass[i] / dt * (change(i, d) - mean - w.cross(d));
  });
}

void turn_velocities(const ParticleSet& p, double dt, std::span<const double> before, std::span<double> after,
                     std::span<double> v, std::span<const double> j) {
  const MeanMotion m = mean_motion(p, before, v);
  if (!m.free) return;
  Vec3 t = Vec3::Zero(), L = m.momentum;
  double total = 0.0;
  for (std::size_t i = 0; i < p.mass.size(); ++i) {
    t += triple(j, i), total += p.mass[i];
    L += (triple(before, i) - m.center).cross(triple(j, i));
  }
  t = p.prescribed.empty() ? Vec3(t / total) : Vec3::Zero();
  if (p.prescribed.empty())
    for (std::size_t i = 0; i < p.mass.size(); ++i) triple(after, i) += dt * t;

  MeanMotion next = frame_of(p, after, v);
  take_inertia(p, after, next);
  const Mat3 R = m.turn(dt);
  const auto own = [&](std::size_t i) -> Vec3 { return R * m.own(triple(before, i), triple(v, i)); };
  for (std::size_t i = 0; i < p.mass.size(); ++i) L -= p.mass[i] * (triple(after, i) - next.center).cross(own(i));
  const Vec3 w = next.spin_of(L);
  for_others(p,
             [&](std::size_t i) { triple(v, i) = m.velocity + t + w.cross(triple(after, i) - next.center) + own(i); });
}

double energy_about_center(std::span<const double> mass, std::span<const double> v) {
  Vec3 momentum = Vec3::Zero();
  double total = 0.0, energy = 0.0;
  for (std::size_t i = 0; i < mass.size(); ++i) {
    total += mass[i];
    momentum += mass[i] * triple(v, i);
  }
  const Vec3 mean = momentum / total;
  for (std::size_t i = 0; i < mass.size(); ++i) energy += 0.5 * mass[i] * (triple(v, i) - mean).squaredNorm();
  return energy;
}

void slow_inner_motion(const ParticleSet& p, std::span<const double> x, double most, std::span<double> v) {
  const double excess = energy_about_center(p.mass, v) - most;
  if (!(excess > 0.0)) return;
  const MeanMotion m = mean_motion(p, x, v);
  const auto own = [&](std::size_t i) { return m.own(triple(x, i), triple(v, i)); };
  double inner = 0.0;
  for (std::size_t i = 0; i < p.mass.size(); ++i) inner += 0.5 * p.mass[i] * own(i).squaredNorm();
  if (!(inner > 0.0)) return;
  const double less = 1.0 - std::sqrt(std::max(0.0, 1.0 - excess / inner));
  for (std::size_t i = 0; i < p.mass.size(); ++i) triple(v, i) -= less * own(i);
}

}  // namespace brim
