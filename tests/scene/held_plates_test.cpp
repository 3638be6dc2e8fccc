#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "brim/scene/scene.h"
#include "support/worlds.h"

/// What lies, rolls and is clamped on plates that a joint holds behaves as on plates that never move.
namespace brim::held_plates_test {
namespace {

constexpr double kGravity = 9.81, kTime = 0.25;

std::string vec(const Vec3& x) { return fmt::format("[{}, {}, {}]", x.x(), x.y(), x.z()); }

/// A ball on a plate turned by an angle about y, its normal n.
struct Tilted {
  double angle;
  Vec3 n() const { return {std::sin(angle), 0.0, std::cos(angle)}; }
  Vec3 down() const { return {std::cos(angle), 0.0, -std::sin(angle)}; }
  World world(const std::string& plate, const std::string& ball, double radius, const std::string& options) const {
    const Vec3 middle = -0.01 * n();
    const std::string joint =
        plate == "rigid"
            ? R"("joints": [{"name": "hold", "kind": "fixed", "body": "plate", "position": )" + vec(middle) + "}], "
            : "";
    return build_world(parse_scene(
        R"({"brim": 1, "name": "t", "frames": 1, "world": {"time_step": 0.004166666666666667, "voxel_size": 0.01, )" +
        options + R"(}, "materials": {"default": {"friction": 0.6}}, )" + joint + R"("bodies": [{"kind": ")" + plate +
        R"(", "name": "plate", "shape": {"kind": "box", "size": [0.6, 0.6, 0.02]}, "transform": {"position": )" +
        vec(middle) + fmt::format(R"(, "rotation": {{"axis": [0, 1, 0], "degrees": {}}}}}}}, )", angle * 180.0 / M_PI) +
        (ball == "points"
             ? R"({"kind": "points", "name": "ball", "rolling_friction": 0, "radius": )" + fmt::format("{}", radius) +
                   R"(, "positions": [)" + vec(radius * n()) + "]}"
             : R"({"kind": "rigid", "name": "ball", "shape": {"kind": "sphere", "radius": )" +
                   fmt::format("{}", radius) + R"(}, "transform": {"position": )" + vec(radius * n()) + "}}") +
        "]}"));
  }
};

TEST(HeldPlates, BallsRollOnThemAsTheoryHasIt) {
  for (const char* response : {"penalty", "constraint"})
    for (const char* plate : {"obstacle", "rigid"})
      for (const char* ball : {"rigid", "points"})
        for (const double angle : {0.02, 0.1}) {
          if (std::string(ball) == "points" && std::string(response) == "constraint") continue;
          const Tilted t{angle};
          World w = t.world(plate, ball, 0.04, fmt::format(R"("response": "{}")", response));
          for (int s = 0; s < 60; ++s) ASSERT_TRUE(w.step().ok);
          const double theory = 5.0 / 7.0 * kGravity * std::sin(angle) * kTime;
          EXPECT_NEAR(testing::velocity(w, 1).dot(t.down()), theory, 0.01 * theory)
              << response << " " << ball << " on " << plate << " at " << angle;
        }
}

TEST(HeldPlates, ABallPressedAlongTheirNormalStays) {
  // Pressed 0.006 voxels beside its lowest point it would start to roll, and a coarse one gain energy down a slope.
  for (const double radius : {0.01, 0.02, 0.04}) {
    const Tilted t{0.02};
    World w = t.world("rigid", "rigid", radius, R"("response": "constraint", "gravity": )" + vec(-kGravity * t.n()));
    for (int s = 0; s < 120; ++s) ASSERT_TRUE(w.step().ok);
    EXPECT_LT(testing::velocity(w, 1).norm(), 1e-4) << radius;
  }
}

TEST(HeldPlates, ASheetBetweenTwoPadsWithoutFrictionIsNotShotOut) {
  World w = build_world(parse_scene(R"({"brim": 1, "name": "t", "frames": 1,
    "world": {"time_step": 0.004166666666666667, "voxel_size": 0.005, "gravity": [0, 0, 0]}, "materials": {"default": {"friction": 0}},
    "joints": [{"name": "low", "kind": "prismatic", "body": "low", "position": [0, 0, 0], "axis": [0, 0, 1]}, {"name": "high", "kind": "prismatic", "body": "high", "position": [0, 0, 0], "axis": [0, 0, 1]}],
    "forces": [{"name": "up", "bodies": ["low"], "force": [0, 0, 10]}, {"name": "down", "bodies": ["high"], "force": [0, 0, -10]}],
    "bodies": [{"kind": "cloth", "name": "sheet", "grid": {"size": [0.05, 0.05], "cells": [8, 8]}, "thickness": 0.006},
      {"kind": "rigid", "name": "low", "mass": 0.2, "shape": {"kind": "box", "size": [0.06, 0.06, 0.02]}, "transform": {"position": [0, 0, -0.0125]}},
      {"kind": "rigid", "name": "high", "mass": 0.2, "shape": {"kind": "box", "size": [0.06, 0.06, 0.02]}, "transform": {"position": [0, 0, 0.0125]}}]})"));
  for (int s = 0; s < 120; ++s) ASSERT_TRUE(w.step().ok);
  Vec3 middle = Vec3::Zero();
  for (int i = 0; i < 81; ++i) middle += Vec3(w.q(0)[3 * i], w.q(0)[3 * i + 1], w.q(0)[3 * i + 2]) / 81.0;
  EXPECT_LT(middle.norm(), 3e-3) << "it flew by two metres in half a second";
}

}  // namespace
}  // namespace brim::held_plates_test
