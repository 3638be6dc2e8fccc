#include "brim/world/fluid_drag.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "brim/body/grid_fluid/grid_fluid_body.h"
#include "brim/body/points/points_body.h"
#include "support/worlds.h"

namespace brim::fluid_drag_test {
namespace {

constexpr double kCell = 0.05;

std::unique_ptr<GridFluidBody> fluid(const Vec3i& n, const std::function<double(const Vec3&)>& distance,
                                     double viscosity = 1e-3) {
  GridFluidModel m;
  m.grid = {Vec3::Zero(), kCell, n};
  m.distance = distance;
  m.viscosity = viscosity;
  m.material.friction = 0.0;
  auto b = std::make_unique<GridFluidBody>(std::move(m));
  b->set_name("fluid");
  return b;
}

double everywhere(const Vec3&) { return -1.0; }

std::unique_ptr<Body> small_ball(const testing::Start& start, double diameter, double density) {
  RigidModel m;
  m.shape = make_sphere(0.5 * diameter);
  m.mass = density * std::numbers::pi / 6.0 * diameter * diameter * diameter;
  m.inertia = 0.1 * m.mass * diameter * diameter * Mat3::Identity();
  m.position = start.x, m.velocity = start.v, m.angular_velocity = start.w;
  m.part.thickness = m.part.width = diameter;
  return std::make_unique<RigidBody>(m);
}

WorldOptions options(double gravity = 9.81) {
  WorldOptions o = testing::options_at(kCell);
  o.time_step = 0.01;
  o.environment.gravity = Vec3(0.0, 0.0, -gravity);
  return o;
}

/// A ball in a box of fluid, and its drag.
struct Immersed {
  explicit Immersed(double diameter, double viscosity = 1e-3) : water(fluid({8, 8, 8}, everywhere, viscosity)) {
    testing::Start start;
    start.x = Vec3(0.21, 0.19, 0.22);
    start.w = Vec3(1.0, -2.0, 3.0);
    ball = small_ball(start, diameter, 1000.0);
    first_v = {0, water->v_size(), water->v_size() + 6};
    v.assign(first_v.back(), 0.0);
    std::vector<double> q(water->q_size());
    const auto of_water = std::span(v).first(first_v[1]);
    water->initial_state(q, of_water);
    water->update(0.0, q, of_water);
    q.resize(ball->q_size());
    ball->initial_state(q, std::span(v).last(6));
    ball->update(0.0, q, std::span(v).last(6));
    part.body = ball.get(), part.body_index = 1, part.info = ball->part(0);
    drag.add(*water, 0, part, 0, shares.of({0, 1}, water->grid(), part));
  }
  std::vector<double> any(unsigned seed) const {
    std::mt19937 random(seed);
    std::vector<double> x(v.size());
    for (double& value : x) value = std::uniform_real_distribution<double>(-1.0, 1.0)(random);
    return x;
  }
  std::unique_ptr<GridFluidBody> water;
  std::unique_ptr<Body> ball;
  std::vector<std::size_t> first_v;
  std::vector<double> v;
  WorldPart part;
  SolidShares shares;
  FluidDrag drag;
};

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double s = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) s += a[i] * b[i];
  return s;
}

TEST(FluidDrag, ProductIsSymmetricAndTakesEnergy) {
  Immersed i(0.06);
  i.drag.begin(i.any(1), i.first_v);
  const std::vector<double> a = i.any(2), b = i.any(3);
  std::vector<double> ya(a.size(), 0.0), yb(a.size(), 0.0);
  i.drag.add_product(0.01, a, ya), i.drag.add_product(0.01, b, yb);
  EXPECT_NEAR(dot(a, yb), dot(b, ya), 1e-12 * std::abs(dot(a, ya)));
  EXPECT_GT(dot(a, ya), 0.0);
  std::vector<double> impulse(a.size(), 0.0);
  i.drag.add_impulse(0.01, a, impulse);
  for (std::size_t k = 0; k < a.size(); ++k) EXPECT_EQ(impulse[k], -ya[k]);
}

TEST(FluidDrag, WhatOneSideTakesTheOtherGives) {
  Immersed i(0.06);
  const std::vector<double> v = i.any(1);
  i.drag.begin(v, i.first_v);
  std::vector<double> impulse(v.size(), 0.0);
  i.drag.add_impulse(0.01, v, impulse);
  Vec3 of_fluid = Vec3::Zero(), told = Vec3::Zero();
  for (std::size_t f = 0; f < i.first_v[1]; ++f) of_fluid[static_cast<Eigen::Index>(f % 3)] += impulse[f];
  const Vec3 of_ball(impulse[i.first_v[1]], impulse[i.first_v[1] + 1], impulse[i.first_v[1] + 2]);
  EXPECT_GT(of_ball.norm(), 1e-6);
  EXPECT_LT((of_fluid + of_ball).norm(), 1e-12 * of_ball.norm());
  i.drag.for_forces(0, 0, v, [&](const Vec3&, const Vec3& force) { told += force; });
  EXPECT_LT((0.01 * told - of_ball).norm(), 1e-12 * of_ball.norm());
}

TEST(FluidDrag, BallsThatCreepAreDraggedByStokesLaw) {
  const double d = 0.05, nu = 1.0;
  Immersed i(d, 1000.0 * nu);
  std::vector<double> v(i.v.size(), 0.0);
  v[i.first_v[1]] = 1e-6;
  i.drag.begin(v, i.first_v);
  std::vector<double> impulse(v.size(), 0.0);
  i.drag.add_impulse(1.0, v, impulse);
  EXPECT_NEAR(-impulse[i.first_v[1]] / (3.0 * std::numbers::pi * 1000.0 * nu * d * 1e-6), 1.0, 0.06);
}

TEST(FluidDrag, WhatTheGridResolvesIsLeftToIt) {
  for (const double cells : {2.4, 2.6}) {
    Immersed i(cells * kCell);
    const std::vector<double> v = i.any(1);
    std::vector<double> impulse(v.size(), 0.0);
    i.drag.begin(v, i.first_v);
    i.drag.add_impulse(0.01, v, impulse);
    EXPECT_EQ(dot(impulse, impulse) == 0.0, cells > 2.5);
  }
}

TEST(FluidDrag, SmallBallsSinkAndRiseAsFastAsTheoryHasIt) {
  // Newton's law, C_d = 0.44, and half the mass of the displaced fluid. The box is sixteen cells wide.
  for (const double cells : {0.4, 0.8, 1.2})
    for (const double density : {2000.0, 400.0}) {
      const double d = cells * kCell, excess = std::abs(density / 1000.0 - 1.0);
      World w(options());
      w.add(fluid({16, 16, 30}, [](const Vec3& x) { return x.z() - 1.4; }));
      testing::Start start;
      start.x = Vec3(0.41, 0.39, density > 1000.0 ? 1.2 : 0.2);
      w.add(small_ball(start, d, density));
      for (int s = 0; s < 60; ++s) ASSERT_TRUE(w.step().ok);
      double u = 0.0;
      for (int k = 0; k < 600; ++k) u += 1e-3 * (excess * 9.81 - 0.33 * u * u / d) / (density / 1000.0 + 0.5);
      EXPECT_NEAR(testing::velocity(w, 1).norm() / u, 1.0, 0.18) << cells << " cells, " << density << " kg/m³";
    }
}

TEST(FluidDrag, MomentumOfADropAndABallInItStays) {
  World w(options(0.0));
  w.add(fluid({16, 16, 16}, [](const Vec3& x) { return (x - Vec3(0.4, 0.4, 0.4)).norm() - 0.25; }));
  testing::Start start;
  start.x = Vec3(0.42, 0.4, 0.39);
  start.v = Vec3(1.0, 0.2, 0.0);
  w.add(small_ball(start, 0.04, 2000.0));
  const auto momentum = [&] { return Vec3(w.body(0).linear_momentum(w.v(0)) + w.body(1).linear_momentum(w.v(1))); };
  const Vec3 before = momentum();
  double energy = w.body(1).kinetic_energy(w.v(1));
  for (int s = 0; s < 15; ++s) {
    const StepReport r = w.step();
    ASSERT_TRUE(r.ok);
    EXPECT_LE(r.kinetic_energy, energy * (1.0 + 1e-9));
    energy = r.kinetic_energy;
  }
  EXPECT_LT((momentum() - before).norm(), 1e-9 * before.norm());
  EXPECT_LT(testing::velocity(w, 1).norm(), 0.7);
}

TEST(FluidDrag, SandSinksInWaterAndRests) {
  WorldOptions o = options();
  o.voxel_size = 0.008;
  World w(o);
  w.add(fluid({8, 8, 12}, [](const Vec3& x) { return x.z() - 0.4; }));
  std::vector<Vec3> grains;
  for (int i = 0; i < 48; ++i)
    grains.push_back(Vec3(0.15 + 0.026 * (i % 4), 0.16 + 0.026 * (i / 4 % 4), 0.43 + 0.026 * (i / 16)));
  PointsOptions sand;
  sand.radius = {0.012};
  w.add(std::make_unique<PointsBody>(grains, sand));
  w.add(testing::ground(0.5));
  StepReport r;
  for (int s = 0; s < 150; ++s) {
    r = w.step();
    ASSERT_TRUE(r.ok);
    EXPECT_TRUE(r.warnings.empty()) << r.warnings.front().message;
  }
  for (std::size_t i = 0; i < grains.size(); ++i) {
    EXPECT_LT(w.q(1)[3 * i + 2], 0.08) << i;
    EXPECT_LT(std::abs(w.v(1)[6 * i + 2]), 0.06) << i;
  }
}

}  // namespace
}  // namespace brim::fluid_drag_test
