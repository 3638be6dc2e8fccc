#include <fmt/format.h>
#include <gtest/gtest.h>

#include "brim/body/articulated/articulated_body.h"
#include "brim/body/obstacle/obstacle_body.h"
#include "brim/math/rotation.h"
#include "brim/world/body_motion.h"
#include "support/soft_worlds.h"

/// What sticks to what turns stays where it is on it, and what rolls there goes where it should (Turning).
namespace brim::turntable_test {
namespace {

constexpr double kSpin = 2.0, kAway = 0.8, kStep = 1.0 / 60.0;

std::unique_ptr<Body> table() {
  ObstacleModel m;
  m.shape = make_box(Vec3(3.0, 3.0, 0.4));
  m.part.voxel_size = 0.05;
  // Keys of a tenth of a second: spherical interpolation turns evenly between them.
  m.keys.clear();
  for (int i = 0; i <= 60; ++i)
    m.keys.push_back({0.1 * i, Vec3(0, 0, -0.2), Quat(rotation_from_vector(Vec3(0, 0, 0.1 * i * kSpin)))});
  return testing::named<ObstacleBody>("table", m);
}

TEST(Turntable, WhatSticksToItKeepsItsPlace) {
  for (const Response response : {Response::Penalty, Response::Constraint})
    for (const bool soft : {false, true}) {
      SCOPED_TRACE(fmt::format("{} {}", response == Response::Penalty ? "penalty" : "rows", soft ? "soft" : "rigid"));
      WorldOptions o = testing::options_at(0.05);
      o.response = response;
      World w(o);
      w.add(table());
      const int b = w.add(soft ? testing::jelly("body", 0.3, Vec3(kAway - 0.15, -0.15, 0.0))
                               : testing::box("body", {Vec3(kAway, 0, 0.15)}, 0.3, 0.3));
      w.set_velocity(b, kSpin * Vec3::UnitZ().cross(Vec3(kAway, 0, 0)), Vec3(0, 0, kSpin));
      const double start = center_of_mass(w.body(b))->head<2>().norm();
      for (int s = 0; s < 120; ++s) w.step();
      const Vec3 at = *center_of_mass(w.body(b));
      // Held to the tangents it would be carried outwards by ω² r dt/2 a second: 53 mm in all, half of it in two
      // sub-steps. Deformable bodies on rows creep by another 5 mm/s.
      EXPECT_NEAR(at.head<2>().norm(), start, soft && response == Response::Constraint ? 0.02 : 0.004);
      EXPECT_NEAR(std::remainder(std::atan2(at.y(), at.x()) - 120 * kStep * kSpin, 2.0 * 3.14159265358979), 0.0, 0.02);
    }
}

LinkModel finger(double y) {
  LinkModel l;
  l.parent = 0;
  l.joint.kind = JointKind::Prismatic;
  l.joint.axis = Vec3(0, 1, 0), l.joint.position = Vec3(kAway, y, 0);
  l.joint.drive.stiffness = 2e4, l.joint.drive.damping = 100, l.joint.drive.target = y > 0 ? -0.003 : 0.003;
  l.mass = 0.5, l.inertia = 0.003 * Mat3::Identity();
  LinkShape s;
  s.shape = make_box(Vec3(0.3, 0.04, 0.3));
  s.part.voxel_size = 0.02;
  l.shapes = {s};
  return l;
}

/// An arm that turns about z, with two fingers at its end that press on what is between them.
std::unique_ptr<Body> arm() {
  ArticulatedModel m;
  LinkModel beam;
  beam.joint.kind = JointKind::Revolute, beam.joint.start_velocity = kSpin;
  beam.joint.drive.damping = 1e4, beam.joint.drive.target_velocity = kSpin;
  beam.mass = 5, beam.inertia = 0.4 * Mat3::Identity();
  m.links = {beam, finger(-0.0705), finger(0.0705)};
  return testing::named<ArticulatedBody>("arm", m);
}

TEST(Turntable, WhatAnArmCarriesStaysInItsFingers) {
  for (const Response response : {Response::Penalty, Response::Constraint}) {
    SCOPED_TRACE(response == Response::Penalty ? "penalty" : "rows");
    WorldOptions o = testing::options_at(0.02);
    o.response = response;
    World w(o);
    w.add(arm());
    const int b = w.add(testing::box("load", {Vec3(kAway, 0, 0)}, 0.1, 0.1));
    w.set_velocity(b, kSpin * Vec3::UnitZ().cross(Vec3(kAway, 0, 0)), Vec3(0, 0, kSpin));
    for (int s = 0; s < 90; ++s) w.step();
    const Vec3 at = *center_of_mass(w.body(b));
    // Held to the tangents it would leave by 10 mm by rows and 20 by penalties.
    EXPECT_NEAR(at.head<2>().norm(), kAway, 2e-4);
    EXPECT_NEAR(at.z(), 0.0, 2e-3);
  }
}

TEST(Turntable, BallsRollOnItInCircles) {
  // A solid ball goes round at 2/7 of the table's rate, wherever it starts (Weltner 1979, "Stable circular orbits of
  // freely moving balls on rotating discs").
  constexpr double kRadius = 0.1, kSpeed = 0.3;
  constexpr int kSteps = 300;
  for (const Response response : {Response::Penalty, Response::Constraint}) {
    SCOPED_TRACE(response == Response::Penalty ? "penalty" : "rows");
    WorldOptions o = testing::options_at(0.025);
    o.response = response, o.max_substeps = 1;
    World w(o);
    w.add(table());
    const Vec3 start(0.2, 0, kRadius), v(0, kSpeed, 0), up = Vec3::UnitZ();
    const int b = w.add(testing::ball("ball", {start}, 0.5, kRadius));
    const Vec3 roll = up.cross(v - kSpin * up.cross(start)) / kRadius;
    w.set_velocity(b, v, roll);
    for (int s = 0; s < kSteps; ++s) w.step();
    const Vec3 end(w.v(b)[0], w.v(b)[1], w.v(b)[2]);
    // Without what the rolling point of contact adds: 3 % slower.
    EXPECT_NEAR(end.norm(), kSpeed, 2e-3 * kSpeed);
    EXPECT_NEAR(std::atan2(-end.x(), end.y()), std::remainder(kSteps * kStep * kSpin * 2.0 / 7.0, 6.283185307179586),
                0.01);
  }
}

}  // namespace
}  // namespace brim::turntable_test
