#include <gtest/gtest.h>

#include "brim/raster/grid_shape.h"
#include "support/worlds.h"

/// Rigid bodies on rows, against the mechanics of rigid bodies.
namespace brim::rigid_motion_laws_test {
namespace {

constexpr double kGravity = 9.81, kStep = 1.0 / 120.0;

WorldOptions rows_at(double h) {
  WorldOptions o = testing::options_at(h);
  o.response = Response::Constraint;
  o.time_step = kStep;
  return o;
}

std::unique_ptr<Body> solid(std::shared_ptr<const Shape> shape, const Vec3& inertia, const testing::Start& s,
                            double mu) {
  RigidModel m;
  m.shape = std::move(shape);
  m.mass = 1.0, m.inertia = inertia.asDiagonal();
  m.position = s.x, m.rotation = s.rotation, m.velocity = s.v, m.angular_velocity = s.w;
  m.part.material.friction = mu;
  auto b = std::make_unique<RigidBody>(m);
  b->set_name("solid");
  return b;
}

TEST(RollingOnRows, AnInclineAcceleratesABallAndACylinderAsTheirInertiaSays) {
  constexpr double R = 0.5, angle = 15.0 / 180.0 * std::numbers::pi;
  const Vec3 n(std::sin(angle), 0.0, std::cos(angle)), down(std::cos(angle), 0.0, -std::sin(angle));
  for (const double h : {R / 2.0, R / 5.0, R / 10.0})
    for (const bool is_ball : {true, false}) {
      SCOPED_TRACE(std::string(is_ball ? "ball" : "cylinder") + ", h = " + std::to_string(h));
      World w(rows_at(h));
      w.add(testing::ground(0.5, n));
      // Off the grid; a cylinder's axis lies across the way down.
      const testing::Start s{R * n + 0.013 * down + Vec3(0, 0.02, 0),
                             Quat::FromTwoVectors(Vec3::UnitZ(), Vec3::UnitY())};
      const double along = R * R / 2.0, across = R * R / 4.0 + 1.0 / 12.0;
      const int b = w.add(is_ball ? solid(make_sphere(R), Vec3::Constant(0.4 * R * R), s, 0.5)
                                  : solid(make_cylinder(R, 1.0), Vec3(across, across, along), s, 0.5));
      constexpr int kSteps = 240;
      for (int i = 0; i < kSteps; ++i) w.step();
      // a = g sin α / (1 + I / (m R²))
      const double v = kGravity * std::sin(angle) / (is_ball ? 1.4 : 1.5) * kSteps * kStep;
      EXPECT_NEAR(testing::velocity(w, b).dot(down), v, 1e-4 * v);
      EXPECT_NEAR(testing::spin(w, b).norm() * R, v, 1e-4 * v);
    }
}

TEST(RollingOnRows, ABallThatSlidesEndsAtFiveSeventhsOfItsSpeed) {
  constexpr double R = 0.5;
  for (const double h : {R / 2.0, R / 5.0, R / 10.0}) {
    World w(rows_at(h));
    w.add(testing::ground(0.2));
    const int b = w.add(testing::ball("ball", {Vec3(0.01, 0.02, R), Quat::Identity(), Vec3(2.0, 0, 0)}, 0.2, R));
    for (int i = 0; i < 240; ++i) w.step();
    EXPECT_NEAR(testing::velocity(w, b).x(), 10.0 / 7.0, 1e-3) << "h = " << h;
    EXPECT_NEAR(testing::spin(w, b).y() * R, 10.0 / 7.0, 1e-3) << "h = " << h;
  }
}

TEST(ImpactsOnRows, ARowOfTouchingBallsSendsOffTheLastAlone) {
  constexpr double R = 0.1;
  for (const double e : {1.0, 0.5})
    for (const int count : {3, 5}) {
      SCOPED_TRACE(count);
      WorldOptions o = rows_at(0.025);
      o.environment.gravity = Vec3::Zero();
      World w(o);
      std::vector<int> balls;
      for (int i = 0; i < count; ++i) {
        RigidModel m;
        m.shape = make_sphere(R);
        m.mass = 1.0, m.inertia = 0.4 * R * R * Mat3::Identity();
        m.position = Vec3(i == 0 ? -0.3 : 2.0 * R * i, 0, 0);
        if (i == 0) m.velocity = Vec3(2, 0, 0);
        m.part.material.friction = 0.0, m.part.material.restitution = e;
        auto body = std::make_unique<RigidBody>(m);
        body->set_name("ball" + std::to_string(i));
        balls.push_back(w.add(std::move(body)));
      }
      for (int i = 0; i < 30; ++i) w.step();
      // Each hands on (1 + e)/2 of its speed.
      double speed = 2.0, momentum = 0.0;
      for (int i = 1; i < count; ++i) speed *= 0.5 * (1.0 + e);
      EXPECT_NEAR(testing::velocity(w, balls.back()).x(), speed, 0.01 * speed);
      for (const int b : balls) momentum += testing::velocity(w, b).x();
      EXPECT_NEAR(momentum, 2.0, 1e-9);
      for (int i = 0; e == 1.0 && i + 1 < count; ++i) EXPECT_NEAR(testing::velocity(w, balls[i]).x(), 0.0, 0.01);
    }
}

/// What spins on a plane, the inertia of its mass about the axis, [m²], and the mean distance of its face from the
/// axis.
struct Spinner {
  const char* name;
  std::shared_ptr<const Shape> shape;
  double inertia, arm, tolerance;
};

TEST(SpinningOnRows, FrictionBrakesWithTheTorqueOfAnEvenPressure) {
  constexpr double R = 0.5, H = 0.25, r = 0.25, mu = 0.3, spin = 8.0;
  const double square = (std::sqrt(2.0) + std::asinh(1.0)) / 6.0;  // of the unit square
  const auto ring = [&](const Vec3& x) {
    const double across = std::abs(std::hypot(x.x(), x.y()) - 0.5 * (R + r)) - 0.5 * (R - r),
                 up = std::abs(x.z()) - 0.5 * H;
    return std::hypot(std::max(across, 0.0), std::max(up, 0.0)) + std::min(std::max(across, up), 0.0);
  };
  const Aabb box{Vec3(-0.7, -0.7, -0.3), Vec3(0.7, 0.7, 0.3)};
  const auto field = std::make_shared<DistanceGrid>(sample_distance(box, 0.02, ring));
  const Spinner spinners[] = {{"disc", make_cylinder(R, H), 0.5 * R * R, 2.0 / 3.0 * R, 0.02},
                              {"box", make_box(Vec3(1.0, 1.0, H)), 1.0 / 6.0, square, 0.02},
                              {"ring", make_grid_shape(field, R - r), 0.5 * (R * R + r * r),
                               2.0 / 3.0 * (R * R * R - r * r * r) / (R * R - r * r), 0.03}};
  for (const double h : {0.125, 0.0625})
    for (const Spinner& s : spinners) {
      World w(rows_at(h));
      w.add(testing::ground(mu));
      const testing::Start start{Vec3(0.013, 0.021, 0.5 * H), Quat::Identity(), Vec3::Zero(), Vec3(0, 0, spin)};
      const int b = w.add(solid(s.shape, Vec3(0.1, 0.1, s.inertia), start, mu));
      int steps = 0;
      while (testing::spin(w, b).z() > 0.1 * spin && steps < 2000) w.step(), ++steps;
      const double arm = s.inertia * (spin - testing::spin(w, b).z()) / (mu * kGravity * steps * kStep);
      EXPECT_NEAR(arm / s.arm, 1.0, s.tolerance) << s.name << ", h = " << h;
      EXPECT_LT(testing::velocity(w, b).norm(), 0.05) << s.name << ", h = " << h;
    }
}

}  // namespace
}  // namespace brim::rigid_motion_laws_test
