#include "brim/scene/sensors.h"

#include <gtest/gtest.h>

#include "brim/core/error.h"
#include "brim/scene/pairs/pair_table.h"
#include "brim/scene/scene.h"
#include "brim/world/sense/sensors.h"
#include "support/sensing.h"

/// Sensors on bodies of every kind, and what scenes say of them.
namespace brim::sensors_test {
namespace {

using testing::reading;
using testing::reading_of_axes;

TEST(SensorScenes, ImpulsesOnEveryKindAreItsChangeOfMomentum) {
  PairTable table = standard_pairs();
  table.drop.speed = 0.5;
  for (const PairKind& upper : table.kinds) {
    if (upper.name == "plane" || upper.name == "mesh") continue;
    Json scene = Json::parse(pair_scene_text(table, table.find("plane"), upper));
    scene["sensors"] = {{{"name", "touch"}, {"kind", "contact"}, {"body", "upper"}},
                        {{"name", "plate"}, {"kind", "force"}, {"body", "lower"}, {"with", "up*"}},
                        {{"name", "probe"}, {"kind", "motion"}, {"body", "upper"}},
                        {{"name", "gauge"}, {"kind", "level"}, {"body", "upper"}, {"point", {0.013, 0.021, 0}}},
                        {{"name", "map"},
                         {"kind", "pressure"},
                         {"body", "lower"},
                         {"grid", {{"origin", {-2, -2, 0}}, {"x", {4, 0, 0}}, {"y", {0, 4, 0}}}}}};
    try {
      World w = build_world(parse_scene(scene.dump()));
      const Vec3 g = w.options().environment.gravity;
      const double m = w.body(1).mass(), dt = w.options().time_step;
      double touched = 0.0;
      for (int s = 0; s < 24; ++s) {
        const Vec3 before = w.body(1).linear_momentum(w.v(1));
        ASSERT_TRUE(w.step().ok) << upper.name;
        const Vec3 gained = w.body(1).linear_momentum(w.v(1)) - before - m * dt * g;
        const Vec3 impulse = reading_of_axes(w, "touch", "impulse");
        touched += impulse.norm();
        // A fluid on a grid projects its velocities after the solve, a tree is solved anew by its joints.
        if (upper.name != "grid_fluid" && upper.name != "articulated") {
          EXPECT_LT((gained - impulse).norm(), 1e-3 * m * 0.5) << upper.name << " in step " << s;
        }
        EXPECT_LT((impulse + reading_of_axes(w, "plate", "impulse")).norm(), 1e-6 * m * 0.5) << upper.name;
        const double pressed = -reading(w, "plate", "force_z");
        EXPECT_NEAR(reading(w, "map", "force") + reading(w, "map", "outside"), pressed,
                    1e-6 * (1.0 + std::abs(pressed)))
            << upper.name;
        EXPECT_NEAR(reading(w, "probe", "velocity_z"), w.body(1).linear_momentum(w.v(1)).z() / m, 1e-9) << upper.name;
      }
      EXPECT_GT(touched, 0.0) << upper.name;
      EXPECT_GE(reading(w, "gauge", "depth"), 0.0) << upper.name;
    } catch (const InputError& e) {
      ADD_FAILURE() << upper.name << ": " << e.what();
    }
  }
}

/// The one thing that is wrong with a scene of a box on a floor, with these sensors.
std::string wrong(const std::string& sensors, const std::string& expect = "[]") {
  try {
    build_world(parse_scene(R"({"brim": 1, "name": "s", "frames": 2, "groups": {"all": ["floor", "box"]}, "bodies": [
      {"kind": "obstacle", "name": "floor", "shape": {"kind": "plane"}},
      {"kind": "rigid", "name": "box", "shape": {"kind": "box", "size": [1, 1, 1]}, "transform": {"position": [0, 0, 0.5]}}],
      "sensors": )" + sensors +
                            R"(, "expect": )" + expect + "}"));
    return "";
  } catch (const InputError& e) {
    return e.what();
  }
}

void expect_says(const std::string& text, const std::string& place, const std::string& words) {
  EXPECT_NE(text.find(place + ": "), std::string::npos) << text;
  EXPECT_NE(text.find(words), std::string::npos) << text;
  EXPECT_EQ(text.find('\n'), std::string::npos) << text;
}

TEST(SensorScenes, WhatIsWrongIsSaidWithItsPlace) {
  EXPECT_EQ(wrong(R"([{"name": "a", "kind": "force", "body": "all"}])"), "");
  expect_says(wrong(R"([{"name": "a", "kind": "force", "body": "flor"}])"), "/sensors/0", "\"flor\" is not a body");
  expect_says(wrong(R"([{"name": "a", "kind": "weight", "body": "floor"}])"), "/sensors/0/kind", "force");
  expect_says(wrong(R"([{"name": "a", "kind": "force", "body": "floor", "gap": 1}])"), "/sensors/0/gap", "unknown key");
  expect_says(wrong(R"([{"name": "a/b", "kind": "force", "body": "floor"}])"), "/sensors/0/name", "no /");
  expect_says(
      wrong(R"([{"name": "a", "kind": "force", "body": "floor"}, {"name": "a", "kind": "force", "body": "box"}])"),
      "/sensors/1/name", "given twice");
  expect_says(wrong(R"([{"name": "a", "kind": "motion", "body": "nobody"}])"), "/sensors/0",
              "\"nobody\" is not a body");
  expect_says(wrong(R"([{"name": "a", "kind": "level", "body": "floor", "point": [0, 0, 0]}])"), "/sensors/0",
              "has no end along z");
  expect_says(wrong(R"([{"name": "a", "kind": "link", "link": "pin"}])"), "/sensors/0", "\"pin\" is not an attachment");
  expect_says(
      wrong(
          R"([{"name": "a", "kind": "pressure", "body": "floor", "grid": {"origin": [0, 0, 0], "x": [1, 0, 0], "y": [1, 1, 0]}}])"),
      "/sensors/0/grid/y", "right angle");
}

TEST(SensorScenes, ExpectationsNameWhatIsThere) {
  const std::string plate = R"([{"name": "plate", "kind": "force", "body": "floor"}])";
  EXPECT_EQ(wrong(plate, R"([{"metric": "sensor", "sensor": "plate", "channel": "force_z", "max": 0}])"), "");
  expect_says(wrong(plate, R"([{"metric": "sensor", "sensor": "plat", "channel": "force_z", "max": 0}])"),
              "/expect/0/sensor", "did you mean \"plate\"?");
  expect_says(wrong(plate, R"([{"metric": "sensor", "sensor": "plate", "channel": "force_w", "max": 0}])"),
              "/expect/0/channel", "must be one of: force_x");
  expect_says(wrong(plate, R"([{"metric": "sensor", "channel": "force_z", "max": 0}])"), "/expect/0",
              "\"sensor\" is missing");
  expect_says(wrong(plate, R"([{"metric": "contacts", "sensor": "plate", "max": 0}])"), "/expect/0", "alone");
}

}  // namespace
}  // namespace brim::sensors_test
