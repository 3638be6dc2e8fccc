#include "brim/world/wind.h"

#include <gtest/gtest.h>

#include <numbers>

#include "brim/body/articulated/articulated_body.h"
#include "brim/body/grid_fluid/grid_fluid_body.h"
#include "brim/body/points/points_body.h"
#include "brim/core/error.h"
#include "support/soft_worlds.h"

/// Laws of wind on what has no triangles, and on bodies of several parts. On surfaces: outer_actions_test.cpp. On every
/// kind: tests/scene/wiring_table_test.cpp.
namespace brim::wind_test {
namespace {

using testing::options_at;

WorldOptions floating(double time_step) {
  WorldOptions o = options_at(0.125);
  o.environment.gravity = Vec3::Zero();
  o.time_step = time_step;
  return o;
}

AppliedForce wind_on(const std::string& body, const Vec3& velocity, double density, double drag) {
  AppliedForce f;
  f.name = "wind", f.bodies = {body};
  f.wind = AppliedForce::Wind{velocity, density, drag, 0.0};
  return f;
}

/// [N] that a world gives its only body in a step so short that nothing moves.
Vec3 force_on(std::unique_ptr<Body> body, const Vec3& velocity, double density, double drag) {
  const double dt = 1e-7;
  World w(floating(dt));
  const std::string name(body->name());
  w.add(std::move(body));
  w.apply(wind_on(name, velocity, density, drag));
  w.step();
  return w.body(0).linear_momentum(w.v(0)) / dt;
}

TEST(Wind, DragOfARodIsThatOfACylinderAcrossTheFlow) {
  const double rho = 1.2, D = 1.1, c = 5.0, L = 2.0;
  const auto rope = [&] { return testing::rope("rope", Vec3(0, 0, 0), Vec3(L, 0, 0)); };
  const double r = rope()->display().radius;
  ASSERT_GT(r, 0.0);
  const double full = 0.5 * rho * D * 2.0 * r * L * c * c;
  EXPECT_LT((force_on(rope(), Vec3(0, 0, c), rho, D) - Vec3(0, 0, full)).norm(), 1e-4 * full);
  EXPECT_LT(force_on(rope(), Vec3(c, 0, 0), rho, D).norm(), 1e-9 * full) << "air along it does not push";
  // Across it the speed is c sin α: half of the force at 45 degrees.
  const Vec3 slanted = force_on(rope(), Vec3(c, 0, c) / std::sqrt(2.0), rho, D);
  EXPECT_LT((slanted - Vec3(0, 0, 0.5 * full)).norm(), 1e-4 * full);
}

TEST(Wind, DragOfParticlesIsThatOfAsManyBalls) {
  const double rho = 1.2, D = 0.47, c = 4.0;
  const auto water = [] { return testing::blob("water", 3, 0.1, Vec3::Zero()); };
  const double r = water()->display().radius, n = 27.0;
  const double full = n * 0.5 * rho * D * std::numbers::pi * r * r * c * c;
  const Vec3 v(0, c * 0.6, c * 0.8);
  EXPECT_LT((force_on(water(), v, rho, D) - full * Vec3(0, 0.6, 0.8)).norm(), 1e-3 * full);
}

/// Water in a box of a cubic metre: a ball of radius 0.3 in its middle, or a pool 0.5 deep.
std::unique_ptr<Body> water_on_grid(bool pool, double friction) {
  GridFluidModel m;
  m.grid.dx = 0.05, m.grid.n = Vec3i::Constant(20);
  m.distance = [pool](const Vec3& x) { return pool ? x.z() - 0.5 : (x - Vec3::Constant(0.5)).norm() - 0.3; };
  m.material.friction = friction;
  return testing::named<GridFluidBody>("water", m);
}

TEST(Wind, DragOfADropOnAGridIsThatOfItsWindwardSurface) {
  const double rho = 1.2, D = 1.0, c = 5.0, R = 0.3;
  const double full = 2.0 / 3.0 * D * 0.5 * rho * c * c * std::numbers::pi * R * R;
  for (const Vec3& way : {Vec3(0, 0, 1), Vec3(0.6, -0.8, 0)}) {
    const Vec3 force = force_on(water_on_grid(false, 0.5), c * way, rho, D);
    EXPECT_LT((force - full * way).norm(), 0.05 * full) << force.transpose() << ", " << full;
  }
}

TEST(Wind, BlowsOnWavesAndNotOnAFlatPoolOrItsWalls) {
  const double rho = 1.2, D = 1.0, c = 5.0;
  const double on_a_wall = 0.5 * rho * D * c * c * 0.5;  // [N] of half a square metre
  // The rim of the shown surface is rounded over a cell, here a twentieth of the side.
  EXPECT_LT(force_on(water_on_grid(true, 0.0), Vec3(c, 0, 0), rho, D).norm(), 0.01 * on_a_wall);
  World w(options_at(0.05));
  w.add(water_on_grid(true, 0.0));
  w.apply(wind_on("water", Vec3(0, 0, -30), rho, 1.0));
  for (int s = 0; s < 20; ++s) ASSERT_TRUE(w.step().ok);
  EXPECT_LT(w.body(0).linear_momentum(w.v(0)).norm(), 1e-3 * w.body(0).mass()) << "[kg m/s] at most 1 mm/s";
}

TEST(OuterActions, AForceInARegionOfAFluidOnAGridActsOnWhatIsThere) {
  const double dt = 1e-4;
  World w(floating(dt));
  w.add(water_on_grid(false, 0.5));
  AppliedForce f;
  f.name = "fan", f.bodies = {"water"}, f.force = Vec3(1, -2, 3);
  f.region = [](const Vec3& x) { return x.x() < 0.45; };
  w.apply(f);
  for (int s = 0; s < 5; ++s) ASSERT_TRUE(w.step().ok);
  EXPECT_LT((w.body(0).linear_momentum(w.v(0)) - 5.0 * dt * f.force).norm(), 1e-3 * 5.0 * dt * f.force.norm());

  World far(floating(dt));
  far.add(water_on_grid(false, 0.5));
  f.region = [](const Vec3& x) { return x.x() > 0.9; };  // dry
  far.apply(f);
  ASSERT_TRUE(far.step().ok);
  EXPECT_EQ(far.body(0).linear_momentum(far.v(0)).norm(), 0.0);
}

TEST(Wind, NothingOutrunsTheAir) {
  for (const bool lines : {true, false}) {
    World w(floating(1.0 / 60.0));
    w.add(lines ? testing::rope("body", Vec3(0, 0, 0), Vec3(1, 0, 0)) : testing::blob("body", 2, 0.1, Vec3::Zero()));
    w.apply(wind_on("body", Vec3(0, 0, 30), 500.0, 2.0));
    const double m = w.body(0).mass();
    double before = 0.0;
    for (int s = 0; s < 60; ++s) {
      ASSERT_TRUE(w.step().ok);
      const double u = w.body(0).linear_momentum(w.v(0)).z() / m;
      EXPECT_LT(u, 30.0 * (1.0 + 1e-9)) << s;
      EXPECT_GE(u, before - 1e-6) << s;
      before = u;
    }
    EXPECT_GT(before, 20.0);
  }
}

/// A free link with a ball at either end of an arm along x: two parts.
std::unique_ptr<Body> dumbbell(double arm) {
  ArticulatedModel m;
  LinkModel l;
  l.name = "bar";
  l.joint.kind = JointKind::Free;
  l.mass = 1000.0, l.inertia = 500.0 * Mat3::Identity();
  for (const double side : {-1.0, 1.0}) {
    LinkShape s;
    s.shape = make_sphere(0.25);
    s.surface = shapes::icosphere(0.25, 3);
    s.pose.translation = Vec3(side * arm, 0, 0);
    s.part.areal_mass = 1e6;
    l.shapes.push_back(std::move(s));
  }
  m.links.push_back(std::move(l));
  return testing::named<ArticulatedBody>("bar", m);
}

TEST(Wind, BlowsOnEachPartOfATreeWhereItIs) {
  const double rho = 1.2, D = 1.0, c = 6.0, arm = 1.5, dt = 1e-6;
  const double ball = 2.0 / 3.0 * D * 0.5 * rho * c * c * std::numbers::pi * 0.0625;
  World w(floating(dt));
  w.add(dumbbell(arm));
  AppliedForce f = wind_on("bar", Vec3::Zero(), rho, D);
  // Along y, on the half of positive x alone.
  f.wind->field = [&](double, std::span<const Vec3> x, std::span<Vec3> u) {
    for (std::size_t i = 0; i < x.size(); ++i) u[i].y() += x[i].x() > 0.0 ? c : 0.0;
  };
  w.apply(f);
  w.step();
  const Vec3 force = w.body(0).linear_momentum(w.v(0)) / dt, torque = w.body(0).angular_momentum(w.v(0)) / dt;
  EXPECT_LT((force - Vec3(0, ball, 0)).norm(), 0.02 * ball);
  EXPECT_LT((torque - Vec3(0, 0, arm * ball)).norm(), 0.02 * arm * ball);
}

TEST(OuterActions, AForceAtAPointOfATreeActsOnThePartThatIsThere) {
  const double arm = 1.5, dt = 1e-6;
  const Vec3 F(0, 3, 4), at(arm, 0.1, 0.2);
  World w(floating(dt));
  w.add(dumbbell(arm));
  AppliedForce f;
  f.name = "f", f.bodies = {"bar"}, f.force = F, f.point = at;
  w.apply(f);
  w.step();
  EXPECT_LT((w.body(0).linear_momentum(w.v(0)) / dt - F).norm(), 1e-8);
  EXPECT_LT((w.body(0).angular_momentum(w.v(0)) / dt - at.cross(F)).norm(), 1e-6);
}

TEST(OuterActions, AForceOnARegionOfATreeIsSharedByThePointsOfAllItsParts) {
  const double arm = 1.5, dt = 1e-6;
  World w(floating(dt));
  w.add(dumbbell(arm));
  AppliedForce f;
  f.name = "f", f.bodies = {"bar"}, f.force = Vec3(0, 0, 8);
  f.region = [](const Vec3&) { return true; };
  w.apply(f);
  w.step();
  EXPECT_LT((w.body(0).linear_momentum(w.v(0)) / dt - Vec3(0, 0, 8)).norm(), 1e-8);
  EXPECT_LT(w.body(0).angular_momentum(w.v(0)).norm() / dt, 1e-6) << "both ends have as many";
}

TEST(OuterActions, AForceInARegionOfAFluidActsOnTheParticlesThatWereThere) {
  const double dt = 1e-6;
  World w(floating(dt));
  w.add(testing::blob("water", 4, 0.1, Vec3::Zero()));
  AppliedForce f;
  f.name = "f", f.bodies = {"water"}, f.force = Vec3(0, 6, 0);
  f.region = [](const Vec3& x) { return x.z() > 0.3; };
  w.apply(f);
  w.step();
  EXPECT_NEAR(w.body(0).linear_momentum(w.v(0)).y() / dt, 6.0, 1e-6);
  double above = 0.0, below = 0.0;
  for (std::size_t i = 0; i < w.q(0).size(); i += 3) {
    double& of = w.q(0)[i + 2] > 0.3 ? above : below;
    of = std::max(of, std::abs(w.v(0)[i + 1]));
  }
  EXPECT_GT(above, 100.0 * below);
}

}  // namespace
}  // namespace brim::wind_test
