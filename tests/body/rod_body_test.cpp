#include "brim/body/rod/rod_body.h"

#include <gtest/gtest.h>

#include <numbers>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "support/implicit.h"
#include "support/particle_laws.h"
#include "support/tiles.h"

namespace brim::rod_body_test {
namespace {

using testing::flat;

constexpr unsigned kSeed = 61;

std::vector<Vec3> straight(int segments, double length) {
  std::vector<Vec3> x;
  for (int i = 0; i <= segments; ++i) x.emplace_back(length * i / segments, 0, 0);
  return x;
}

std::vector<Vec3> circle(int segments, double radius) {
  std::vector<Vec3> x;
  for (int i = 0; i < segments; ++i) {
    const double a = 2 * std::numbers::pi * i / segments;
    x.emplace_back(radius * std::cos(a), radius * std::sin(a), 0);
  }
  return x;
}

RodOptions options() {
  RodOptions o;
  o.stretch = 100.0;
  o.bending = 0.5;
  o.linear_density = 0.2;
  o.radius = 0.05;
  return o;
}

/// Straight, curved, closed, and a rope with a curved start.
std::vector<std::unique_ptr<RodBody>> one_of_each() {
  std::vector<std::unique_ptr<RodBody>> all;
  all.push_back(std::make_unique<RodBody>(straight(10, 1.0), options()));
  std::vector<Vec3> wave;
  for (int i = 0; i <= 12; ++i) wave.emplace_back(0.1 * i, 0.2 * std::sin(0.5 * i), 0.1 * std::cos(0.3 * i));
  all.push_back(std::make_unique<RodBody>(wave, options()));
  RodOptions o = options();
  o.closed = true;
  all.push_back(std::make_unique<RodBody>(circle(12, 0.3), o));
  o = options();
  o.rests_straight = true;
  all.push_back(std::make_unique<RodBody>(wave, o));
  return all;
}

std::vector<double> deformed(const ParticleBody& body, double amount) {
  testing::Noise noise(kSeed);
  const Mat3 R = Eigen::AngleAxisd(1.0, Vec3(1, 1, 0).normalized()).toRotationMatrix();
  std::vector<Vec3> x;
  for (const Vec3& p : body.rest_positions()) x.push_back(R * (p + amount * noise.vec()));
  return flat(x);
}

TEST(RodBody, OneRightAngleByHand) {
  // Two edges of 1 m at a right angle: |κ| = 2 tan 45° = 2, E = ½ (B / 1 m) 2².
  RodOptions o = options();
  RodBody body(straight(2, 2.0), o);
  testing::set(body, {-1, 0, 0, 0, 0, 0, 0, 1, 0});
  EXPECT_NEAR(body.elastic_energy(), 0.5 * 0.5 * 4, 1e-12);
  // dE/dφ = B |κ| / cos²(φ/2) · 1 = 0.5 · 2 · 2; the ends are pushed across their edges, to open the angle.
  EXPECT_NEAR((body.inner_forces()[0] + Vec3(0, 2, 0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((body.inner_forces()[2] - Vec3(2, 0, 0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR(body.mass(), 0.4, 1e-15);
  EXPECT_NEAR(body.length(), 2.0, 1e-15);
}

TEST(RodBody, ForcesAreMinusTheDerivativeOfEnergy) {
  for (const auto& body : one_of_each())
    testing::expect_force_is_minus_energy_gradient(*body, deformed(*body, 0.02), 1e-7, 1e-6, kSeed);
}

TEST(RodBody, StiffnessIsTheDerivativeOfForcesWhereTheRodIsStraightOrAtRest) {
  for (const auto& body : one_of_each()) {
    if (body->elastic_energy() > 0.0) continue;
    testing::expect_stiffness_is_force_derivative(*body, flat(body->rest_positions()), 1e-7, 1e-5, kSeed);
  }
}

TEST(RodBody, StiffnessIsSymmetricAndDefinite) {
  for (const auto& body : one_of_each()) {
    testing::expect_stiffness_is_symmetric_and_definite(*body, deformed(*body, 0.02), kSeed);
    testing::expect_stiffness_is_symmetric_and_definite(*body, deformed(*body, 0.3), kSeed);
  }
}

TEST(RodBody, InnerForcesHaveNoResultantAndNoTorque) {
  for (const auto& body : one_of_each()) testing::expect_inner_forces_balance(*body, deformed(*body, 0.03));
}

TEST(RodBody, RigidMotionMakesNoForce) {
  const auto all = one_of_each();
  for (std::size_t i = 0; i < 3; ++i) testing::expect_rigid_motion_makes_no_force(*all[i], Mat3::Identity());
}

TEST(RodBody, ARingHasTheEnergyOfACircle) {
  // A straight rod bent into a circle: ½ B/R² · 2πR, to second order in the edge.
  double last = 1.0;
  for (const int n : {8, 16, 32}) {
    RodOptions o = options();
    o.closed = true;
    o.rests_straight = true;
    RodBody ring(circle(n, 0.5), o);
    const double error = std::abs(ring.elastic_energy() / (0.5 * 0.5 / 0.5 * 2 * std::numbers::pi) - 1.0);
    EXPECT_LT(error, 0.3 * last) << n;
    last = error;
  }
  EXPECT_LT(last, 0.01);
}

/// Tip deflection of a clamped rod under its own small weight q per metre, over q L⁴ / (8 B).
double cantilever(int n) {
  RodOptions o = options();
  const double L = 1.0, B = 0.5;
  o.stretch = 1e4;
  o.fixed = {0, 1};
  RodBody body(straight(n, L), o);
  testing::Stepper stepper(body);
  Environment env;
  env.gravity = Vec3(0, 0, -0.05);
  stepper.relax(5, env);
  const double free = L * (n - 0.5) / n;  // clamped in the middle of the first edge
  return -stepper.position(n).z() / (0.2 * 0.05 * std::pow(free, 4) / (8 * B));
}

TEST(RodBody, CantileverBendsAsBeamTheorySays) {
  const double coarse = cantilever(10), middle = cantilever(20), fine = cantilever(40);
  RecordProperty("ratio", fmt::format("{:.5f} {:.5f} {:.5f}", coarse, middle, fine));
  EXPECT_LT(std::abs(middle - 1.0), 0.6 * std::abs(coarse - 1.0));
  EXPECT_LT(std::abs(fine - 1.0), 0.6 * std::abs(middle - 1.0));
  EXPECT_NEAR(fine, 1.0, 0.03);
}

TEST(RodBody, HangingChainIsACatenary) {
  // Ends 1.6 m apart, 2 m of chain that hardly stretches: y = a cosh(x/a), 2 a sinh(0.8/a) = 2.
  double a = 0.5;
  for (int i = 0; i < 100; ++i) {
    const double f = a * std::sinh(0.8 / a) - 1.0, df = std::sinh(0.8 / a) - 0.8 / a * std::cosh(0.8 / a);
    a -= f / df;
  }
  double last = 1.0;
  for (const int n : {10, 20, 40}) {
    RodOptions o = options();
    o.stretch = 1e6;
    o.bending = 0.0;
    o.fixed = {0, n};
    std::vector<Vec3> x;
    // A start of the right length: a V.
    for (int i = 0; i <= n; ++i) {
      const double s = 2.0 * i / n - 1.0;
      x.emplace_back(0.8 * s, 0, 0.6 * (std::abs(s) - 1.0));
    }
    RodBody body(x, o);
    testing::Stepper stepper(body);
    for (int s = 0; s < 200; ++s) {
      std::fill(stepper.v.begin(), stepper.v.end(), 0.0);
      stepper.step(0.5, Environment{}, 1e-8);
    }
    double worst = 0.0;
    for (int i = 0; i <= n; ++i) {
      const Vec3 p = stepper.position(i);
      worst = std::max(worst, std::abs(p.z() - a * (std::cosh(p.x() / a) - std::cosh(0.8 / a))));
    }
    RecordProperty("error_" + std::to_string(n), fmt::format("{:.2e}", worst));
    EXPECT_LT(worst, 0.4 * last) << n;
    last = worst;
  }
  EXPECT_LT(last, 2e-3);
}

TEST(RodBody, MapIsExactForRigidMotionButForTheSpinAboutTheRod) {
  RodBody body(straight(8, 0.8), options());
  testing::set(body, deformed(body, 0.01));
  const double h = body.part(0).voxel_size, w = 3 * h;
  std::vector<TileKey> tiles;
  body.presence(0, h, w, body.bounds(0).inflated(1.0), tiles);
  std::vector<DensityBlock> blocks(tiles.size());
  body.rasterize(0, h, w, tiles, blocks);
  const std::vector<TileKey> around = testing::tiles_around(body.bounds(0).inflated(w), h);
  std::vector<DensityBlock> all(around.size());
  body.rasterize(0, h, w, around, all);
  testing::expect_present(around, all, tiles);
  std::vector<Vec3> points;
  std::vector<std::int32_t> sources;
  testing::for_each_node(tiles, h, [&](std::size_t t, int n, const Vec3& r) {
    if (blocks[t].rho[n] > 0.0) points.push_back(r), sources.push_back(blocks[t].source[n]);
  });
  ASSERT_GT(points.size(), 500u);
  std::vector<Vec3> v, u(points.size());
  const Vec3 omega(1, -2, 0.5);
  for (const Vec3& x : body.positions()) v.push_back(Vec3(1, 2, 3) + omega.cross(x));
  std::unique_ptr<Map> map;
  body.make_map(0, points, sources, map);
  map->apply(flat(v), u);
  for (std::size_t p = 0; p < points.size(); ++p) {
    const auto& s = body.display().lines[sources[p]];
    const Vec3 a = body.positions()[s[0]], t = (body.positions()[s[1]] - a).normalized();
    const Vec3 seen = omega - omega.dot(t) * t;  // without spin
    const Vec3 axis = a + t * t.dot(points[p] - a);
    const Vec3 expected = Vec3(1, 2, 3) + omega.cross(axis) + seen.cross(points[p] - axis);
    ASSERT_LT((u[p] - expected).norm(), 1e-12);
  }
}

TEST(RodBody, ThreadsDoNotChangeABit) {
  RodOptions o = options();
  RodBody body(straight(3000, 30.0), o);
  const std::vector<double> q = deformed(body, 0.002);
  std::vector<double> force, product;
  for (const int threads : {1, 2, 4}) {
    ThreadLimit limit(threads);
    testing::set(body, q);
    body.begin_solve(0.01);
    std::vector<double> y(q.size(), 0.0);
    body.apply_system(q, y);
    if (force.empty()) force = flat(body.inner_forces()), product = y;
    EXPECT_EQ(flat(body.inner_forces()), force);
    EXPECT_EQ(y, product);
  }
}

TEST(RodBody, BadInputIsRefusedWithAMessage) {
  EXPECT_THROW(RodBody({Vec3::Zero()}, options()), InputError);
  EXPECT_THROW(RodBody({Vec3::Zero(), Vec3::Zero()}, options()), InputError);
  EXPECT_THROW(RodBody({Vec3::Zero(), Vec3::UnitX(), Vec3::Zero()}, options()), InputError) << "folds back";
  RodOptions o = options();
  o.closed = true;
  EXPECT_THROW(RodBody(straight(1, 1.0), o), InputError);
  for (double RodOptions::*number : {&RodOptions::radius, &RodOptions::linear_density, &RodOptions::stretch}) {
    o = options();
    o.*number = 0.0;
    EXPECT_THROW(RodBody(straight(4, 1.0), o), InputError);
  }
  o = options();
  o.bending = -1.0;
  EXPECT_THROW(RodBody(straight(4, 1.0), o), InputError);
}

}  // namespace
}  // namespace brim::rod_body_test
