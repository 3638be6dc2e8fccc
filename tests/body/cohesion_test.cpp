#include "brim/body/particle_fluid/cohesion.h"

#include <gtest/gtest.h>

#include <random>

#include "brim/body/particle_fluid/particle_fluid_body.h"
#include "support/worlds.h"

namespace brim::cohesion_test {
namespace {

constexpr double kSpacing = 0.05, kTension = 25.0;

std::unique_ptr<ParticleFluidBody> drop(int side, double jitter, double viscosity) {
  std::mt19937 rng(11);
  std::uniform_real_distribution<double> noise(-jitter * kSpacing, jitter * kSpacing);
  const double half = 0.5 * side * kSpacing;
  std::vector<Vec3> x = lattice_in_box(Vec3::Constant(-half), Vec3::Constant(half), kSpacing).x;
  for (Vec3& p : x) p += Vec3(noise(rng), noise(rng), noise(rng));
  ParticleFluidOptions o;
  o.spacing = kSpacing;
  o.viscosity = viscosity;
  o.surface_tension = kTension;
  o.initial_velocity = Vec3(0.1, -0.2, 0.3);
  o.initial_spin = Vec3(0.2, 0.1, -0.1);
  auto b = std::make_unique<ParticleFluidBody>(std::move(x), o);
  b->set_name("drop");
  return b;
}

TEST(Cohesion, PullIsTheDerivativeOfItsEnergyAndPushesWhatIsNear) {
  const Cohesion c(0.1, kSpacing, kTension);
  for (const double r : {0.005, 0.02, 0.04, 0.0501, 0.07, 0.095}) {
    const double e = 1e-6;
    const double slope = (c.energy(r + e) - c.energy(r - e)) / (2.0 * e);
    EXPECT_NEAR(c.pull_over_r(r) * r, slope, 1e-6 * c.pull_over_r(0.05) * 0.05) << r;
  }
  EXPECT_LT(c.pull_over_r(0.01), 0.0);
  EXPECT_GT(c.pull_over_r(0.03), 0.0);
  EXPECT_EQ(c.pull_over_r(0.1), 0.0);
  EXPECT_FALSE(Cohesion(0.1, kSpacing, 0.0).acts());
}

TEST(Cohesion, CuttingABlockTakesTwiceTheTensionPerArea) {
  // By brute force over all pairs of a thick slab, away from its rim.
  const Cohesion c(2.0 * kSpacing, kSpacing, kTension);
  const int n = 6;
  double cut = 0.0;
  for (int z = -3; z < 0; ++z)
    for (int k = 0; k < 3; ++k)
      for (int j = -n; j <= n; ++j)
        for (int i = -n; i <= n; ++i) cut -= c.energy(kSpacing * Vec3(i, j, k - z).norm());
  EXPECT_NEAR(cut / (kSpacing * kSpacing), 2.0 * kTension, 1e-9 * kTension);
}

TEST(Cohesion, ForcesOnParticlesAreMinusTheDerivativeOfEnergyAndHaveNoResultant) {
  auto body = drop(4, 0.2, 0.0);
  std::vector<double> q(body->q_size()), v(body->v_size()), Q(body->v_size(), 0.0);
  body->initial_state(q, v);
  body->update(0.0, q, v);
  const Environment none{Vec3::Zero()};
  body->add_forces(none, Q);
  std::mt19937 rng(23);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::vector<double> d(q.size()), at(q.size());
  for (double& x : d) x = unit(rng);
  const double e = 1e-6;
  const auto energy = [&](double s) {
    for (std::size_t i = 0; i < q.size(); ++i) at[i] = q[i] + s * d[i];
    body->update(0.0, at, v);
    return body->potential_energy(none);
  };
  const double slope = (energy(e) - energy(-e)) / (2.0 * e);
  double work = 0.0, size = 0.0;
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  for (std::size_t i = 0; i < q.size(); ++i) work += Q[i] * d[i], size += std::abs(Q[i]);
  for (std::size_t i = 0; i < q.size() / 3; ++i) {
    const Vec3 F(Q[3 * i], Q[3 * i + 1], Q[3 * i + 2]), x(q[3 * i], q[3 * i + 1], q[3 * i + 2]);
    force += F, torque += x.cross(F);
  }
  EXPECT_NEAR(-slope, work, 1e-4 * std::abs(work));
  EXPECT_LT(force.norm(), 1e-7 * size);
  EXPECT_LT(torque.norm(), 1e-7 * size);
}

TEST(Cohesion, ACubicDropBecomesRoundAndKeepsItsMomentum) {
  WorldOptions o = testing::options_at(0.5 * kSpacing);
  o.environment.gravity.setZero();
  o.time_step = 0.005;
  o.cg_tolerance = 1e-8;
  World w(o);
  w.add(drop(6, 0.0, 20.0));
  // Σ (x⁴ + y⁴ + z⁴) / Σ r⁴ about the middle: 0.474 for a cube, 3/5 for a ball.
  const auto roundness = [&] {
    const auto q = w.q(0);
    Vec3 middle = Vec3::Zero();
    const std::size_t n = q.size() / 3;
    for (std::size_t i = 0; i < n; ++i) middle += Vec3(q[3 * i], q[3 * i + 1], q[3 * i + 2]) / double(n);
    double quartic = 0.0, all = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3 r = Vec3(q[3 * i], q[3 * i + 1], q[3 * i + 2]) - middle;
      quartic += r.array().square().square().sum();
      all += r.squaredNorm() * r.squaredNorm();
    }
    return quartic / all;
  };
  EXPECT_LT(roundness(), 0.49);
  const Vec3 p = w.body(0).linear_momentum(w.v(0)), l = w.body(0).angular_momentum(w.v(0));
  double energy = 0.0;
  for (int s = 0; s < 300; ++s) {
    const StepReport r = w.step();
    ASSERT_TRUE(r.ok);
    const double now = r.kinetic_energy + r.potential_energy;
    if (s > 0) {
      EXPECT_LT(now, energy + 1e-3 * std::abs(energy));
    }
    energy = now;
  }
  const Vec3 dp = w.body(0).linear_momentum(w.v(0)) - p, dl = w.body(0).angular_momentum(w.v(0)) - l;
  RecordProperty("roundness", std::to_string(roundness()));
  RecordProperty("linear", std::to_string(dp.norm() / p.norm()));
  RecordProperty("angular", std::to_string(dl.norm() / l.norm()));
  EXPECT_NEAR(roundness(), 0.6, 0.012);
  EXPECT_LT(dp.norm(), 1e-5 * p.norm());
  EXPECT_LT(dl.norm(), 1e-2 * l.norm());
}

}  // namespace
}  // namespace brim::cohesion_test
