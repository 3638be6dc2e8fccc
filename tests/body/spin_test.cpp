#include <gtest/gtest.h>

#include "brim/body/cloth/cloth_body.h"
#include "brim/body/fem/fem_body.h"
#include "brim/body/mass_spring/mass_spring_body.h"
#include "brim/body/rod/rod_body.h"
#include "brim/mesh/primitives.h"
#include "support/carried.h"
#include "support/implicit.h"
#include "support/particle_laws.h"

namespace brim::spin_test {
namespace {

/// One body of each deformable kind, free, about half a metre large, spinning at 6 rad/s about an axis of none of its
/// symmetries.
std::vector<std::unique_ptr<ParticleBody>> spinning(double damping) {
  ElasticOptions soft = testing::soft(1e5);
  FemOptions solid;
  ClothOptions sheet;
  MassSpringOptions springs;
  RodOptions rod;
  sheet.areal_density = 1.0, sheet.membrane.young = 1e4, sheet.bending = 0.5;
  rod.stretch = 1e4, rod.bending = 1.0, rod.linear_density = 1.0, rod.radius = 0.02;
  for (ParticleOptions* o : std::initializer_list<ParticleOptions*>{&soft, &solid, &sheet, &springs, &rod}) {
    o->stiffness_damping = damping;
    o->initial_spin = Vec3(3.6, 0.0, 4.8);
    o->initial_velocity = Vec3(0.5, -1.0, 2.0);
  }
  std::vector<std::unique_ptr<ParticleBody>> all;
  all.push_back(std::make_unique<FemBody>(testing::block(4, 2, 2, 0.1), solid));
  all.push_back(std::make_unique<ClothBody>(shapes::grid(6, 5, 0.5, 0.4), sheet));
  all.push_back(std::make_unique<MassSpringBody>(testing::block(4, 2, 2, 0.1), springs));
  std::vector<Vec3> bow;
  for (int i = 0; i <= 10; ++i) bow.emplace_back(0.05 * i, 0.02 * i * (10 - i) * 0.1, 0.0);
  all.push_back(std::make_unique<RodBody>(bow, rod));
  all.push_back(testing::meshless(Vec3(0.4, 0.2, 0.2), 0.1, 0.05, soft));
  all.push_back(testing::voxels(Vec3(0.4, 0.2, 0.2), 0.1, 0.05, soft));
  return all;
}

Environment weightless() {
  Environment env;
  env.gravity.setZero();
  return env;
}

class Spin : public ::testing::TestWithParam<std::pair<double, double>> {};

TEST_P(Spin, OfAFreeBodyOfAnyKindStaysAndItsEnergyDoesNotGrow) {
  const auto [dt, damping] = GetParam();
  for (const auto& body : spinning(damping)) {
    SCOPED_TRACE(body->kind());
    testing::Stepper s(*body);
    const Environment env = weightless();
    const Vec3 L = body->angular_momentum(s.v), P = body->linear_momentum(s.v);
    double energy = body->kinetic_energy(s.v) + body->potential_energy(env);
    const double start = energy;
    for (int i = 0; i < std::lround(1.0 / dt); ++i) {
      s.step(dt, env, 1e-13);
      body->update(s.time, s.q, s.v);
      const double now = body->kinetic_energy(s.v) + body->potential_energy(env);
      EXPECT_LE(now, energy + 1e-3 * start) << "at " << s.time << " s";
      energy = std::max(energy, now);
    }
    EXPECT_LE(energy, 1.001 * start);
    EXPECT_LT((body->angular_momentum(s.v) - L).norm(), 1e-10 * L.norm());
    EXPECT_LT((body->linear_momentum(s.v) - P).norm(), 1e-10 * P.norm());
  }
}

INSTANTIATE_TEST_SUITE_P(Steps, Spin,
                         ::testing::Values(std::pair(1.0 / 60, 0.0), std::pair(1.0 / 60, 0.02),
                                           std::pair(1.0 / 240, 0.0), std::pair(1.0 / 240, 0.02)));

TEST(Spin, OfGuidedStretchedMatterHasNoRateOfForce) {
  // A rope, a net and a sheet, stretched: between guided particles forces that only turn with the matter have no rate
  // in the step, though K has one.
  for (const auto& body : spinning(0.0)) {
    if (body->kind() != "rod" && body->kind() != "mass_spring" && body->kind() != "cloth") continue;
    SCOPED_TRACE(body->kind());
    std::vector<double> q(body->q_size()), v(q.size()), turn(q.size()), whole(q.size(), 0.0), strain(q.size(), 0.0);
    body->initial_state(q, v);
    for (double& e : q) e *= 1.2;
    body->update(0.0, q, v);
    body->rigid_motion(Vec3(0.1, 0.2, 0.3), Vec3(1.0, -2.0, 1.5), turn);
    body->apply_stiffness(turn, whole);
    body->set_guided(std::vector<std::uint8_t>(q.size() / 3, 1));
    body->apply_start_stiffness(turn, strain);
    double size = 0.0, rest = 0.0;
    for (std::size_t i = 0; i < q.size(); ++i)
      size = std::max(size, std::abs(whole[i])), rest = std::max(rest, std::abs(strain[i]));
    EXPECT_GT(size, 1.0);
    EXPECT_LT(rest, 1e-4 * size) << "single precision of the blocks";
    // None guided: all of K.
    body->set_guided(std::vector<std::uint8_t>(q.size() / 3, 0));
    std::fill(strain.begin(), strain.end(), 0.0);
    body->apply_start_stiffness(turn, strain);
    EXPECT_EQ(strain, whole);
  }
}

TEST(Spin, AboutAFixedParticleStays) {
  // A straight rod on a pivot, without weight: angular momentum about the pivot.
  RodOptions o;
  o.stretch = 1e4, o.bending = 1.0, o.linear_density = 1.0;
  o.fixed = {0};
  std::vector<Vec3> x;
  for (int i = 0; i <= 10; ++i) x.emplace_back(0.05 * i, 0.0, 0.0);
  RodBody body(x, o);
  testing::Stepper s(body);
  for (std::size_t i = 0; i < x.size(); ++i) s.v[3 * i + 1] = 4.0 * x[i].x();
  body.update(0.0, s.q, s.v);
  const Vec3 L = body.angular_momentum(s.v);
  for (int i = 0; i < 60; ++i) s.step(1.0 / 60, weightless(), 1e-13);
  body.update(s.time, s.q, s.v);
  EXPECT_LT((body.angular_momentum(s.v) - L).norm(), 1e-10 * L.norm());
  EXPECT_EQ(Vec3(s.q[0], s.q[1], s.q[2]), x[0]);
}

}  // namespace
}  // namespace brim::spin_test
