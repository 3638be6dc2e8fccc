#include <fmt/format.h>
#include <gtest/gtest.h>

#include "brim/body/obstacle/obstacle_body.h"
#include "brim/math/rotation.h"
#include "brim/world/body_motion.h"
#include "support/soft_worlds.h"

/// What sticks to a turning table stays where it is on it (Turning).
namespace brim::turntable_test {
namespace {

constexpr double kSpin = 2.0, kAway = 0.8, kStep = 1.0 / 60.0;

std::unique_ptr<Body> table() {
  ObstacleModel m;
  m.shape = make_box(Vec3(3.0, 3.0, 0.4));
  m.part.voxel_size = 0.05;
  // Keys of a tenth of a second: spherical interpolation turns evenly between them.
  m.keys.clear();
  for (int i = 0; i <= 40; ++i)
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

}  // namespace
}  // namespace brim::turntable_test
