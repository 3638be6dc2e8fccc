#pragma once

#include <gtest/gtest.h>

#include "brim/body/particles/particle_body.h"
#include "support/solids.h"

/// Laws that every elastic body of particles obeys; each takes a body and a state.
namespace brim::testing {

/// Rounding of numbers in single precision.
inline constexpr double kSingle = std::numeric_limits<float>::epsilon();

inline std::vector<double> flat(std::span<const Vec3> x) {
  std::vector<double> q;
  for (const Vec3& p : x) q.insert(q.end(), {p.x(), p.y(), p.z()});
  return q;
}

inline void set(ParticleBody& body, const std::vector<double>& q) {
  body.update(0.0, q, std::vector<double>(body.v_size(), 0.0));
}

/// f = −∂E/∂x along random directions, by central differences.
inline void expect_force_is_minus_energy_gradient(ParticleBody& body, const std::vector<double>& q, double step,
                                                  double relative, unsigned seed) {
  SCOPED_TRACE(seed);
  Noise noise(seed);
  for (int trial = 0; trial < 10; ++trial) {
    std::vector<double> d(q.size());
    for (double& e : d) e = noise();
    auto plus = q, minus = q;
    for (std::size_t i = 0; i < q.size(); ++i) plus[i] += step * d[i], minus[i] -= step * d[i];
    set(body, plus);
    const double up = body.elastic_energy();
    set(body, minus);
    const double down = body.elastic_energy();
    set(body, q);
    double work = 0.0, scale = 0.0;
    for (std::size_t i = 0; i < q.size(); ++i) {
      const double f = body.inner_forces()[i / 3][static_cast<int>(i % 3)];
      work += f * d[i];
      scale += f * f;
    }
    EXPECT_NEAR(work, -(up - down) / (2 * step), relative * std::sqrt(scale));
    EXPECT_GT(scale, 0.0);
  }
}

/// apply_stiffness = the derivative of the forces, where projection does nothing.
inline void expect_stiffness_is_force_derivative(ParticleBody& body, const std::vector<double>& q, double step,
                                                 double relative, unsigned seed) {
  SCOPED_TRACE(seed);
  Noise noise(seed);
  for (int trial = 0; trial < 10; ++trial) {
    std::vector<double> d(q.size());
    for (double& e : d) e = noise();
    auto plus = q, minus = q;
    for (std::size_t i = 0; i < q.size(); ++i) plus[i] += step * d[i], minus[i] -= step * d[i];
    set(body, plus);
    const auto up = flat(body.inner_forces());
    set(body, minus);
    const auto down = flat(body.inner_forces());
    set(body, q);
    std::vector<double> Kd(q.size(), 0.0);
    body.apply_stiffness(d, Kd);
    double error = 0.0, size = 0.0;
    for (std::size_t i = 0; i < q.size(); ++i) {
      error += std::pow(Kd[i] - (up[i] - down[i]) / (2 * step), 2);
      size += Kd[i] * Kd[i];
    }
    EXPECT_LT(std::sqrt(error), relative * std::sqrt(size));
  }
}

/// The stiffness operator is symmetric and takes no negative energy, but for its blocks' single precision.
inline void expect_stiffness_is_symmetric_and_definite(ParticleBody& body, const std::vector<double>& q,
                                                       unsigned seed) {
  SCOPED_TRACE(seed);
  Noise noise(seed);
  set(body, q);
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<double> a(body.v_size()), b(body.v_size()), Ka(body.v_size(), 0.0), Kb(body.v_size(), 0.0);
    for (double& e : a) e = noise();
    for (double& e : b) e = noise();
    body.apply_stiffness(a, Ka);
    body.apply_stiffness(b, Kb);
    double ab = 0, ba = 0, aa = 0, size = 0;
    for (std::size_t i = 0; i < body.v_size(); ++i) {
      ab += b[i] * Ka[i], ba += a[i] * Kb[i], aa += a[i] * Ka[i];
      size += std::abs(b[i] * Ka[i]);
    }
    EXPECT_NEAR(ab, ba, kSingle * size);
    EXPECT_LE(aa, kSingle * size);
  }
}

/// Inner forces have no resultant and no torque.
inline void expect_inner_forces_balance(ParticleBody& body, const std::vector<double>& q) {
  set(body, q);
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  double size = 0.0;
  for (std::size_t i = 0; i < body.particle_count(); ++i) {
    const Vec3 f = body.inner_forces()[i];
    force += f;
    torque += body.positions()[i].cross(f);
    size += f.norm();
  }
  EXPECT_GT(size, 0.0);
  EXPECT_LT(force.norm(), 1e-13 * size);
  EXPECT_LT(torque.norm(), 1e-12 * size);
}

/// A rigid motion of the rest shape makes no force, measured against a displacement of one in a thousand.
/// @param gradient  of that displacement, times 1000; it must strain the body
inline void expect_rigid_motion_makes_no_force(ParticleBody& body,
                                               const Mat3& gradient = Mat3{{0, 1, 0}, {1, 0, 0}, {1, 0, 0}}) {
  const Mat3 R = Eigen::AngleAxisd(2.1, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  std::vector<Vec3> moved, strained;
  for (const Vec3& x : body.rest_positions()) {
    moved.push_back(R * x + Vec3(3, -1, 2));
    strained.push_back(x + 1e-3 * gradient * x);
  }
  set(body, flat(strained));
  double reference = 0.0, force = 0.0;
  const double energy = body.elastic_energy();
  for (const Vec3& f : body.inner_forces()) reference = std::max(reference, f.norm());
  set(body, flat(moved));
  for (const Vec3& f : body.inner_forces()) force = std::max(force, f.norm());
  EXPECT_GT(reference, 0.0);
  EXPECT_LT(force, 1e-9 * reference);
  EXPECT_LT(std::abs(body.elastic_energy()), 1e-9 * energy);
}

}  // namespace brim::testing
