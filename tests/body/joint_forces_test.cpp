#include "brim/body/articulated/joint_forces.h"

#include <gtest/gtest.h>

#include "brim/body/articulated/articulated_body.h"
#include "support/trees.h"

namespace brim::joint_forces_test {
namespace {

using testing::random_tree;
using testing::TreeNoise;

/// One joint that carries a ball of 2 kg a metre away.
ArticulatedModel arm(JointKind kind) {
  ArticulatedModel m;
  m.links.resize(1);
  m.links[0].joint.kind = kind;
  m.links[0].mass = 2.0;
  m.links[0].center_of_mass = Vec3(1, 0, 0);
  m.links[0].inertia = 0.1 * Mat3::Identity();
  return m;
}

struct Still {
  ArticulatedBody body;
  std::vector<double> q, v;
  explicit Still(const ArticulatedModel& m) : body(m), q(body.q_size()), v(body.v_size()) {
    body.initial_state(q, v);
    body.update(0.0, q, v);
  }
  std::vector<double> force() {
    std::vector<double> Q(v.size(), 0.0);
    body.add_forces({Vec3::Zero()}, Q);
    return Q;
  }
  std::vector<double> operator()(void (ArticulatedBody::*apply)(std::span<const double>, std::span<double>) const,
                                 const std::vector<double>& x) {
    std::vector<double> y(x.size(), 0.0);
    (body.*apply)(x, y);
    return y;
  }
};

/// Everything that can act in a joint.
ArticulatedModel busy_tree(unsigned seed) {
  ArticulatedModel m = random_tree(seed, false);
  TreeNoise noise(seed + 100);
  for (LinkModel& l : m.links) {
    l.joint.drive = {30.0, 0.7, 1e9, noise(), noise(), {}};
    l.joint.upper = 0.3, l.joint.lower = -0.2;
    l.joint.limit_stiffness = 200.0;
    l.joint.damping = 0.4;
  }
  return m;
}

TEST(JointForces, DriveAndLimitByHand) {
  ArticulatedModel m = arm(JointKind::Revolute);
  m.links[0].joint.start = 0.5, m.links[0].joint.start_velocity = 2.0;
  m.links[0].joint.drive.stiffness = 10.0, m.links[0].joint.drive.damping = 3.0;
  m.links[0].joint.drive.target = 1.5, m.links[0].joint.drive.target_velocity = 1.0;
  EXPECT_NEAR(Still(m).force()[0], 10.0 * 1.0 + 3.0 * (1.0 - 2.0), 1e-14);
  m.links[0].joint.drive.force_limit = 4.0;
  EXPECT_NEAR(Still(m).force()[0], 4.0, 1e-14);
  m.links[0].joint.drive = {};
  m.links[0].joint.upper = 0.4, m.links[0].joint.limit_stiffness = 100.0;
  const double limit = -100.0 * (0.5 - 0.4 + 2.0 / 60.0);  // k (q − upper + dt q')
  EXPECT_NEAR(Still(m).force()[0], limit, 1e-13);
  m.links[0].joint.damping = 1.5;
  EXPECT_NEAR(Still(m).force()[0], limit - 3.0, 1e-13);
}

TEST(JointForces, ForceWithoutVelocityIsMinusTheDerivativeOfTheEnergy) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    Still s(busy_tree(seed));
    std::fill(s.v.begin(), s.v.end(), 0.0);
    TreeNoise noise(seed);
    const double e = 1e-6;
    for (int trial = 0; trial < 5; ++trial) {
      const auto d = noise.list(s.v.size());
      const auto energy = [&](double t) {
        auto q = s.q;
        s.body.advance(t, q, d);
        s.body.update(0.0, q, s.v);
        return s.body.potential_energy({Vec3::Zero()});
      };
      const double slope = (energy(e) - energy(-e)) / (2 * e);
      energy(0.0);
      const auto Q = s.force();
      double drive_velocity = 0.0, work = 0.0, size = 0.0;
      for (const auto& l : s.body.tree().links())  // the drives' target velocities push too, and are no energy
        if (l.dof == 1)
          drive_velocity +=
              0.7 * s.body.drive(static_cast<int>(&l - s.body.tree().links().data())).target_velocity * d[l.v0];
      for (std::size_t i = 0; i < Q.size(); ++i) work += Q[i] * d[i], size += std::abs(Q[i] * d[i]);
      EXPECT_NEAR(work - drive_velocity, -slope, 1e-7 * size);
      EXPECT_GT(size, 1.0);
    }
  }
}

TEST(JointForces, StiffnessAndDampingAreTheDerivativesOfTheForce) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    Still s(busy_tree(seed));
    TreeNoise noise(seed);
    const double e = 1e-6;
    auto d = noise.list(s.v.size());
    for (const auto& l : s.body.tree().links())  // a ball's stiffness is exact about rest only: tested by definiteness
      if (l.dof == 3)
        for (int k = 0; k < 3; ++k) d[l.v0 + k] = 0.0;
    const auto force = [&](double move, double push) {
      auto q = s.q, v = s.v;
      s.body.advance(move, q, d);
      for (std::size_t i = 0; i < v.size(); ++i) v[i] += push * d[i];
      s.body.update(0.0, q, v);
      return s.force();
    };
    const auto up = force(e, 0), down = force(-e, 0), faster = force(0, e), slower = force(0, -e);
    force(0, 0);
    const auto Kd = s(&ArticulatedBody::apply_stiffness, d), Cd = s(&ArticulatedBody::apply_damping, d);
    for (std::size_t i = 0; i < d.size(); ++i) {
      EXPECT_NEAR(Kd[i], (up[i] - down[i]) / (2 * e), 1e-6);
      EXPECT_NEAR(Cd[i], (faster[i] - slower[i]) / (2 * e), 1e-6);
    }
  }
}

TEST(JointForces, StiffnessAndDampingTakeNoNegativeEnergyAndMakeTheSystem) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    ArticulatedModel m = busy_tree(seed);
    for (LinkModel& l : m.links) l.joint.friction = 2.0, l.joint.drive.force_limit = 5.0;
    Still s(m);
    const double dt = 0.01;
    s.body.begin_solve(dt);
    TreeNoise noise(seed);
    for (int trial = 0; trial < 10; ++trial) {
      const auto x = noise.list(s.v.size());
      const auto K = s(&ArticulatedBody::apply_stiffness, x), C = s(&ArticulatedBody::apply_damping, x);
      const auto M = s(&ArticulatedBody::apply_mass, x), A = s(&ArticulatedBody::apply_system, x);
      double k = 0, c = 0;
      for (std::size_t i = 0; i < x.size(); ++i) {
        k += x[i] * K[i], c += x[i] * C[i];
        EXPECT_NEAR(A[i], M[i] - dt * C[i] - dt * dt * K[i], 1e-12 * (1.0 + std::abs(A[i])));
      }
      EXPECT_LE(k, 0.0);
      EXPECT_LT(c, 0.0);
    }
  }
}

TEST(JointForces, DiagonalBlocksAreThoseOfTheSystem) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    Still s(busy_tree(seed));
    s.body.begin_solve(0.02);
    BlockDiagonal D;
    D.reset(s.body.block_sizes());
    s.body.add_system_diagonal(0, D);
    for (std::size_t b = 0; b < D.block_count(); ++b)
      for (int c = 0; c < D.block_size(b); ++c) {
        std::vector<double> unit(s.v.size(), 0.0);
        unit[D.block_row(b) + c] = 1.0;
        const auto column = s(&ArticulatedBody::apply_system, unit);
        for (int r = 0; r < D.block_size(b); ++r)
          EXPECT_NEAR(D.block(b)(r, c), column[D.block_row(b) + r],
                      1e-11 * (1.0 + std::abs(column[D.block_row(b) + r])));
      }
  }
}

TEST(JointForces, PreconditionerIsTheInverseOfTheSystem) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    Still s(busy_tree(seed));
    s.body.begin_solve(0.02);
    BlockDiagonal D;
    D.reset(s.body.block_sizes());
    s.body.prepare_preconditioner(0, D);
    TreeNoise noise(seed);
    const auto x = noise.list(s.v.size());
    const auto r = s(&ArticulatedBody::apply_system, x);
    std::vector<double> z(x.size());
    s.body.precondition(0, D, r, z);
    for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(z[i], x[i], 1e-9);
  }
}

TEST(JointForces, AJointWithNothingInItHasNoForce) {
  Still s(random_tree(4, true));
  EXPECT_EQ(s.force(), std::vector<double>(s.v.size(), 0.0));
}

}  // namespace
}  // namespace brim::joint_forces_test
