#include "brim/scene/wind_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "brim/core/error.h"
#include "brim/scene/scene.h"
#include "brim/world/world.h"

namespace brim::wind_field_test {
namespace {

std::string scene_of(const std::string& wind) {
  return R"({"brim": 1, "name": "wind", "frames": 1, "parameters": {"speed": 3}, "world": {"gravity": [0, 0, 0]},
    "bodies": [{"kind": "cloth", "name": "flag", "grid": {"size": [1, 1], "cells": [4, 4]}, "areal_density": 1000}],
    "forces": [{"name": "wind", "bodies": ["flag"], "wind": )" +
         wind + "}]}";
}

Vec3 pushed(const std::string& wind) {
  World w = build_world(parse_scene(scene_of(wind)));
  EXPECT_TRUE(w.step().ok);
  return w.body(0).linear_momentum(w.v(0)) / w.state().time;
}

std::string message_of(const std::string& wind) {
  try {
    build_world(parse_scene(scene_of(wind)));
    return "";
  } catch (const InputError& e) {
    return e.what();
  }
}

TEST(WindField, AFormulaOfNumbersIsTheUniformWind) {
  const Vec3 uniform = pushed(R"({"velocity": [0, 0, 3], "drag": 1.1})");
  EXPECT_GT(uniform.z(), 5.0);
  for (const char* wind :
       {R"w({"field": {"velocity": [0, 0, "=speed"]}, "drag": 1.1})w",
        R"w({"field": {"velocity": ["0", "0", "2 + U*cos(t)"], "constants": {"U": "=speed/3"}}, "drag": 1.1})w",
        R"w({"velocity": [0, 0, 1], "field": {"velocity": [0, 0, "2 - t"]}, "drag": 1.1})w"})
    EXPECT_EQ(pushed(wind), uniform) << wind;
}

TEST(WindField, PlacesCountWhereTheTransformPutsThem) {
  // Blows on x > 0 alone, which is half the flag, or on none of it where its axes lie elsewhere.
  const auto half = [](const std::string& transform) {
    const std::string field = R"w({"drag": 1, "field": {"velocity": [0, 0, "3 * min(1, max(0, 1e6 * x))"])w";
    return pushed(field + transform + "}}").norm();
  };
  const double all = pushed(R"({"drag": 1, "velocity": [0, 0, 3]})").norm();
  EXPECT_NEAR(half(""), 0.5 * all, 1e-4 * all);  // but for how the flag gives way within the step
  EXPECT_NEAR(half(R"(, "transform": {"position": [-2, 0, 0]})"), all, 1e-9 * all);
  EXPECT_EQ(half(R"(, "transform": {"position": [2, 0, 0]})"), 0.0);
  // Turned by a quarter about x, what blows along z blows along −y, past the flag.
  EXPECT_LT(half(R"(, "transform": {"position": [-2, 0, 0], "rotation": {"axis": [1, 0, 0], "degrees": 90}})"), 1e-12);
}

TEST(WindField, MistakesAreSaidWhereTheyStand) {
  EXPECT_NE(message_of(R"({"field": {"velocity": [0, 0, "2 * q"]}})").find("/forces/0/wind/field/velocity/2"),
            std::string::npos);
  EXPECT_NE(message_of(R"({"field": {"velocity": [0, 0, "2 * spead"], "constants": {"speed": 1}}})")
                .find("did you mean \"speed\"?"),
            std::string::npos);
  EXPECT_NE(message_of(R"w({"field": {"velocity": [0, "sin(", 0]}})w").find("at character"), std::string::npos);
  EXPECT_NE(message_of(R"({"field": {"velocity": [0, 0, 0], "constants": {"x": 1}}})").find("has a meaning already"),
            std::string::npos);
  EXPECT_NE(message_of(R"({"field": {"velocity": [0, 0]}})"), "");
}

}  // namespace
}  // namespace brim::wind_field_test
