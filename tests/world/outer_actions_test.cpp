#include "brim/world/outer_actions.h"

#include <gtest/gtest.h>

#include "brim/core/error.h"
#include "brim/world/applied_force.h"
#include "support/soft_worlds.h"

/// Laws of what acts from outside. Those for every kind: tests/scene/links_test.cpp.
namespace brim::outer_actions_test {
namespace {

using testing::ball;
using testing::box;
using testing::options_at;
using testing::position;
using testing::run;
using testing::spin;
using testing::velocity;

WorldOptions floating() {
  WorldOptions o = options_at(0.125);
  o.environment.gravity = Vec3::Zero();
  return o;
}

AppliedForce on(const std::string& body) {
  AppliedForce f;
  f.name = "f", f.bodies = {body};
  return f;
}

TEST(OuterActions, DampingTakesTheShareOfItsExponential) {
  World w(floating());
  w.add(ball("ball", {Vec3::Zero(), Quat::Identity(), Vec3(1, 2, 3), Vec3(0, 0, 4)}));
  AppliedForce f = on("ball");
  f.damping = 0.7;
  w.apply(f);
  run(w, 1.0);
  EXPECT_LT((velocity(w, 0) - std::exp(-0.7) * Vec3(1, 2, 3)).norm(), 1e-9);
  EXPECT_NEAR(spin(w, 0).z(), 4.0 * std::exp(-0.7), 1e-6);
}

TEST(OuterActions, AForceAtAPointTurnsTheBodyByItsLever) {
  World w(floating());
  w.add(box("box", {Vec3::Zero()}));
  AppliedForce f = on("box");
  f.force = Vec3(0, 500, 0), f.point = Vec3(0.5, 0, 0);
  w.apply(f);
  w.step();
  const double t = w.state().time;
  EXPECT_NEAR(velocity(w, 0).y(), 500.0 * t / 1000.0, 1e-9);
  EXPECT_NEAR(spin(w, 0).z(), 0.5 * 500.0 * t / (1000.0 / 6.0), 1e-6);
}

TEST(OuterActions, KeysScaleAForceOverTime) {
  World w(floating());
  w.add(ball("ball", {Vec3::Zero()}));
  AppliedForce f = on("ball");
  f.acceleration = Vec3(2, 0, 0);
  f.scale = {{0.0, 0.0}, {1.0, 1.0}};
  w.apply(f);
  run(w, 2.0);
  EXPECT_NEAR(velocity(w, 0).x(), 2.0 * (0.5 + 1.0), 0.04);  // forces are those of the start of a sub-step
}

TEST(OuterActions, WindOnAPlateAndOnABallIsWhatIntegrationSays) {
  const double c = 3.0, rho = 1.2;
  AppliedForce f = on("body");
  f.wind = AppliedForce::Wind{Vec3(0, 0, c), rho, 1.1, 0.0};
  {
    World w(floating());
    w.add(testing::sheet("body", 1.0, Vec3::Zero()));  // 1 kg/m², across the wind
    w.apply(f);
    w.step();
    const double full = 0.5 * rho * 1.1 * c * c;
    const double p = w.body(0).linear_momentum(w.v(0)).z() / w.state().time;
    EXPECT_LT(p, full);
    EXPECT_GT(p, 0.9 * full);  // less what would bring it beyond the air's speed
  }
  World w(floating());
  RigidModel m;
  m.shape = make_sphere(0.5);
  m.mass = 1e6;  // hardly moves
  m.inertia = Mat3::Identity() * 1e6;
  m.surface = shapes::icosphere(0.5, 4);
  m.part.areal_mass = 1e6;
  w.add(testing::named<RigidBody>("body", m));
  w.apply(f);
  w.step();
  const double expected = 2.0 / 3.0 * 1.1 * 0.5 * rho * c * c * std::numbers::pi * 0.25;
  EXPECT_NEAR(w.body(0).linear_momentum(w.v(0)).z() / w.state().time, expected, 0.02 * expected);
}

TEST(OuterActions, WindNeverBringsASheetBeyondItsSpeed) {
  World w(floating());
  w.add(testing::sheet("body", 1.0, Vec3::Zero()));
  AppliedForce f = on("body");
  f.wind = AppliedForce::Wind{Vec3(0, 0, 20), 50.0, 2.0, 1.0};
  w.apply(f);
  for (int s = 0; s < 60; ++s) {
    w.step();
    EXPECT_LT(w.body(0).mean_velocity(0, w.v(0)).z(), 20.02);  // its own waves swing about the air's speed
  }
  EXPECT_GT(w.body(0).mean_velocity(0, w.v(0)).z(), 17.0);
}

TEST(OuterActions, AFieldOfAirIsWhatUniformAirWouldBeAtEachPlaceAndTime) {
  // A vortex of rigid turning, about a ball in its middle: no force, and the torque of its own drag by quadrature.
  const double spin_of_air = 3.0, rho = 1.2, R = 0.5;
  const auto heavy_ball = [&] {
    RigidModel m;
    m.shape = make_sphere(R);
    m.mass = 1e6, m.inertia = Mat3::Identity() * 1e6;
    m.surface = shapes::icosphere(R, 4);
    m.part.areal_mass = 1e6;
    return testing::named<RigidBody>("body", m);
  };
  {
    World w(floating());
    w.add(heavy_ball());
    AppliedForce f = on("body");
    f.wind = AppliedForce::Wind{Vec3::Zero(), rho, 1.0, 0.0};
    f.wind->field = [&](double, std::span<const Vec3> x, std::span<Vec3> u) {
      for (std::size_t i = 0; i < x.size(); ++i) u[i] += spin_of_air * Vec3(0, 0, 1).cross(x[i]);
    };
    w.apply(f);
    w.step();
    EXPECT_LT(velocity(w, 0).norm() * 1e6, 1e-3);
    EXPECT_LT(spin(w, 0).norm() * 1e6, 1e-2) << "air that flows along a surface does not push it";
  }
  // Air U (1 + x/L) t along x: the force on the windward half is the integral of ½ ρ D U² t² (1 + x/L)² cos² over it.
  World w(floating());
  w.add(heavy_ball());
  const double U = 4.0, L = 2.0;
  AppliedForce f = on("body");
  f.wind = AppliedForce::Wind{Vec3::Zero(), rho, 1.0, 0.0};
  f.wind->field = [&](double t, std::span<const Vec3> x, std::span<Vec3> u) {
    for (std::size_t i = 0; i < x.size(); ++i) u[i].x() += t * U * (1.0 + x[i].x() / L);
  };
  w.apply(f);
  run(w, 1.0);
  const double p0 = w.body(0).linear_momentum(w.v(0)).x(), t0 = w.state().time;
  w.step();
  const double force = (w.body(0).linear_momentum(w.v(0)).x() - p0) / (w.state().time - t0);
  // With x = −R c, dA = 2 π R² dc:  ∫_0^1 (1 − R c/L)² c² 2 π R² dc
  const double a = R / L, integral = 2.0 * std::numbers::pi * R * R * (1.0 / 3.0 - 2.0 * a / 4.0 + a * a / 5.0);
  EXPECT_NEAR(force, 0.5 * rho * U * U * t0 * t0 * integral, 0.01 * force);
}

TEST(OuterActions, AnAttractorOfPowerOneIsASpringAboutItsCenter) {
  World w(floating());
  w.add(ball("ball", {Vec3(0.5, 0, 0)}));
  AppliedForce f = on("ball");
  f.attractor = AppliedForce::Attractor{Vec3::Zero(), 4.0, 1.0, 1.0};  // ω = 2 / s
  w.apply(f);
  double t = 0.0;
  while (t == 0.0 && w.state().time < 2.0) {
    w.step();
    if (position(w, 0).x() < 0.0) t = w.state().time;
  }
  EXPECT_NEAR(t, 0.25 * std::numbers::pi, 0.03);
}

TEST(OuterActions, GravityMayChangeBetweenSteps) {
  World w(options_at(0.125));
  w.add(ball("ball", {Vec3(0, 0, 5)}));
  run(w, 0.5);
  const double v = velocity(w, 0).z();
  w.set_gravity(Vec3::Zero());
  run(w, 0.5);
  EXPECT_NEAR(velocity(w, 0).z(), v, 1e-12);
}

TEST(OuterActions, ABodyThatIsAddedAfterAGravityScaleHasGravityOfOne) {
  World w(options_at(0.125));
  w.add(ball("light", {Vec3(0, 0, 5)}));
  AppliedForce lift{"lift", {"light"}};
  lift.gravity_scale = 0.25;
  w.apply(lift);
  for (int i = 0; i < 40; ++i) w.add(ball("ball" + std::to_string(i), {Vec3(2.0 * (i + 1), 0, 5)}));
  w.step();
  const double fall = velocity(w, 1).z();
  EXPECT_NEAR(fall, -9.81 * w.options().time_step, 1e-12);
  EXPECT_NEAR(velocity(w, 0).z(), 0.25 * fall, 1e-12);
  EXPECT_NEAR(velocity(w, 40).z(), fall, 1e-12);
}

TEST(OuterActions, WhatCannotBeIsRefused) {
  World w(floating());
  w.add(testing::ground(0.5));
  w.add(ball("ball", {Vec3(0, 0, 5)}));
  EXPECT_THROW(w.apply(on("ground")), InputError);
  EXPECT_THROW(w.apply(on("bull")), InputError);
  AppliedForce f = on("ball");
  f.point = Vec3::Zero();
  EXPECT_THROW(w.apply(f), InputError);
  f.force = Vec3(1, 0, 0);
  EXPECT_EQ(w.apply(f), 0);
  EXPECT_THROW(w.apply(f), InputError) << "the name is taken";
}

}  // namespace
}  // namespace brim::outer_actions_test
