#include "brim/scene/parameters.h"

#include <gtest/gtest.h>

#include <string>

#include "brim/core/error.h"
#include "brim/scene/errors.h"
#include "brim/scene/presets.h"
#include "brim/scene/scene.h"

namespace brim::parameters_test {
namespace {

/// A ball on a floor whose numbers are parameters.
const char* const kBall = R"({
  "brim": 1, "name": "ball", "frames": 2,
  "parameters": {"r": {"value": 0.2, "description": "radius"}, "h": "=r/10", "size": [1, 1, 1], "what": "ball"},
  "world": {"voxel_size": "=h"},
  "bodies": [
    {"kind": "rigid", "name": "=what", "shape": {"kind": "sphere", "radius": "=r"},
     "transform": {"position": [0, 0, "=2*r + 0.1"]}},
    {"kind": "rigid", "name": "==box", "shape": {"kind": "box", "size": "=size"}}]
})";

constexpr const char* kNoWorld = R"({"brim": 1, "name": "s", "frames": 1, "bodies": [
  {"kind": "rigid", "name": "ball", "shape": {"kind": "sphere", "radius": 0.1}}]})";

Scene scene_of(const std::string& text, const SceneSettings& settings = {}) {
  return check_scene(parse_document(text, "scene.json"), settings);
}

std::string message_of(const std::string& text, const SceneSettings& settings = {}) {
  try {
    scene_of(text, settings);
    return "";
  } catch (const InputError& e) {
    return e.what();
  }
}

SceneSettings set(const std::string& name, Json value) {
  SceneSettings s;
  s.set[name] = std::move(value);
  return s;
}

double radius_of(const Scene& s) { return s.document->root["bodies"][0]["shape"]["radius"].get<double>(); }

TEST(Parameters, StandInForValuesAndAreComputedFromEachOther) {
  const Scene s = scene_of(kBall);
  EXPECT_DOUBLE_EQ(s.world.voxel_size, 0.02);
  EXPECT_DOUBLE_EQ(radius_of(s), 0.2);
  const Json& bodies = s.document->root["bodies"];
  EXPECT_DOUBLE_EQ(bodies[0]["transform"]["position"][2].get<double>(), 0.5);
  EXPECT_EQ(bodies[0]["name"], "ball");
  EXPECT_EQ(bodies[1]["name"], "=box");
  EXPECT_EQ(s.text, kBall) << "a scene as written is kept byte for byte";
}

TEST(Parameters, SettingOneChangesWhatFollowsFromItAndTheKeptTextMakesTheSameScene) {
  const Scene s = scene_of(kBall, set("r", 0.4));
  EXPECT_DOUBLE_EQ(s.world.voxel_size, 0.04);
  const Scene again = scene_of(s.text);
  EXPECT_EQ(again.document->root, s.document->root);
  const Scene direct = scene_of(kBall, set("/world/voxel_size", 0.125));
  EXPECT_DOUBLE_EQ(direct.world.voxel_size, 0.125);
  EXPECT_DOUBLE_EQ(scene_of(kBall, set("/world/time_step", 0.01)).world.time_step, 0.01) << "a key may be new";
  EXPECT_DOUBLE_EQ(scene_of(kNoWorld, set("/world/time_step", 0.01)).world.time_step, 0.01) << "and so may the world";
}

TEST(Parameters, WhatIsWrongIsSaidWithItsPlace) {
  const auto spoilt = [](const std::string& find, const std::string& replace) {
    std::string text = kBall;
    return text.replace(text.find(find), find.size(), replace);
  };
  EXPECT_NE(message_of(spoilt("\"=h\"", "\"=hh\"")).find("scene.json:4: /world/voxel_size: \"=hh\""),
            std::string::npos);
  EXPECT_NE(message_of(spoilt("\"=h\"", "\"=hh\"")).find("did you mean \"h\"?"), std::string::npos);
  EXPECT_NE(message_of(spoilt("\"value\": 0.2", "\"value\": \"=h\"")).find("computed from itself"), std::string::npos);
  EXPECT_NE(message_of(kBall, set("q", 1)).find("no parameter \"q\""), std::string::npos);
  EXPECT_NE(message_of(kBall, set("r", "wide")).find("another type"), std::string::npos);
  EXPECT_NE(message_of(kBall, set("/worlds/x", 1)).find("no such place"), std::string::npos);
  EXPECT_NE(message_of(kBall, set("/bodies/7", 1)).find("no such place"), std::string::npos);
  EXPECT_NE(message_of(kBall, set("r", -1)).find("/bodies/0/shape/radius: -1 is not allowed"), std::string::npos);
}

TEST(Parameters, LongChainsAndWhatGrowsWithoutBoundAreRefused) {
  std::string chain = "\"p0\": 1";
  for (int i = 1; i < 300; ++i) chain += ", \"p" + std::to_string(i) + "\": \"=p" + std::to_string(i - 1) + "\"";
  EXPECT_NE(message_of(R"({"brim": 1, "name": "s", "parameters": {"last": "=p299", )" + chain + R"(}, "bodies": []})")
                .find("a chain of more than 200"),
            std::string::npos);
  std::string list = "0", uses = "\"=l\"";
  for (int i = 1; i < 100000; ++i) list += ",0";
  for (int i = 1; i < 12; ++i) uses += ", \"=l\"";
  EXPECT_NE(message_of(R"({"brim": 1, "name": "s", "parameters": {"l": [)" + list + R"(]}, "bodies": [)" + uses + "]}")
                .find("write more than 1000000 values"),
            std::string::npos);
}

TEST(Parameters, SettingsAreReadAsJsonOrText) {
  EXPECT_EQ(read_setting("h=0.02").second, 0.02);
  EXPECT_EQ(read_setting("size=[1,2]").second, Json::array({1, 2}));
  EXPECT_EQ(read_setting("what=a b").second, "a b");
  EXPECT_THROW(read_setting("h"), InputError);
  EXPECT_THROW(read_setting("=3"), InputError);
}

TEST(Parameters, ASeedGoesToItsParameterOrToEveryRepeat) {
  const std::string pile = R"({"brim": 1, "name": "pile", "frames": 1, "bodies": [
    {"kind": "rigid", "name": "a", "shape": {"kind": "sphere", "radius": 1}, "repeat": {"count": [1, 1, 2]}},
    {"kind": "rigid", "name": "b", "shape": {"kind": "sphere", "radius": 1}, "repeat": {"count": [1, 1, 2], "seed": 7}}]})";
  SceneSettings s;
  s.seed = 3;
  const Scene other = scene_of(pile, s);
  EXPECT_EQ(other.document->root["bodies"][0]["repeat"]["seed"], 3);
  EXPECT_EQ(other.document->root["bodies"][1]["repeat"]["seed"], 9);
  s.seed = 1;
  EXPECT_EQ(scene_of(pile, s).document->root, scene_of(pile).document->root) << "seed 1 is the scene as written";
  EXPECT_NE(message_of(kBall, s).find("nothing of the scene is random"), std::string::npos);
}

TEST(Parameters, ASeedThatIsLeftOutIsCountedOnAsWell) {
  SceneSettings s;
  s.seed = 4;
  const Scene other = scene_of(R"({"brim": 1, "name": "heap", "frames": 1, "bodies": [
    {"kind": "points", "name": "a", "radius": 0.1, "grid": {"count": [2, 2, 2], "spacing": 0.25, "jitter": 0.02}},
    {"kind": "rigid", "name": "b", "shape": {"kind": "blob", "radius": 1}, "transform": {"position": [5, 0, 0]}}]})",
                               s);
  EXPECT_EQ(other.document->root["bodies"][0]["seed"], 4);
  EXPECT_EQ(other.document->root["bodies"][1]["shape"]["seed"], 4);
}

TEST(Presets, GiveNumbersThatAreNotGiven) {
  const Scene s = scene_of(R"({"brim": 1, "name": "p", "frames": 1,
    "materials": {"tyre": {"preset": "rubber", "restitution": 0.1}, "plate": {"preset": "steel"}},
    "pairs": [{"materials": ["tyre", "plate"], "preset": "rubber on steel"}],
    "bodies": [
      {"kind": "rigid", "name": "a", "preset": "steel", "shape": {"kind": "sphere", "radius": 0.1}},
      {"kind": "rigid", "name": "b", "preset": "steel", "mass": 3, "shape": {"kind": "sphere", "radius": 0.1}},
      {"kind": "cloth", "name": "c", "preset": "cotton", "grid": {"size": [1, 1], "cells": [4, 4]}}]})");
  const Json& bodies = s.document->root["bodies"];
  EXPECT_EQ(bodies[0]["density"], 7850);
  EXPECT_FALSE(bodies[1].contains("density")) << "a mass is given";
  EXPECT_EQ(bodies[2]["areal_density"], material_presets()["cotton"]["bodies"]["cloth"]["areal_density"]);
  EXPECT_DOUBLE_EQ(s.materials.at("tyre").restitution, 0.1);
  EXPECT_DOUBLE_EQ(s.world.pair_materials.begin()->second.friction, 0.8);
}

TEST(Presets, EachHasASourceAndIsAcceptedByItsKinds) {
  for (const auto& [name, preset] : material_presets().items()) {
    EXPECT_GT(preset.value("source", "").size(), 20u) << name;
    if (!preset.contains("bodies")) continue;
    for (const auto& [kind, keys] : preset.at("bodies").items()) {
      Json body = {{"kind", kind}, {"name", "a"}, {"preset", name}, {"nonsense", 1}};
      const Json scene = {{"brim", 1}, {"name", "p"}, {"frames", 1}, {"bodies", Json::array({body})}};
      const std::string message = message_of(scene.dump());
      // All that is said of the body is the key that no kind knows, and what is missing of its shape.
      for (const auto& [key, unused] : keys.items())
        EXPECT_EQ(message.find("/bodies/0/" + key), std::string::npos) << name << " " << kind << ": " << message;
    }
  }
}

TEST(Presets, OfAnotherKindAreRefused) {
  const char* const text = R"({"brim": 1, "name": "p", "frames": 1, "bodies": [
    {"kind": "rigid", "name": "a", "preset": "hony", "shape": {"kind": "sphere", "radius": 0.1}},
    {"kind": "rigid", "name": "b", "preset": "boen", "shape": {"kind": "sphere", "radius": 0.1}}]})";
  EXPECT_NE(message_of(text).find("/bodies/0/preset: \"hony\" is no preset of the kind \"rigid\""), std::string::npos)
      << message_of(text);
  EXPECT_NE(message_of(text).find("did you mean \"bone\"?; there are: bone, rubber, steel"), std::string::npos);
}

TEST(Presets, OfTheNameOfAMissingMaterialAreHintedAt) {
  const auto text = [](const char* material) {
    return message_of(fmt::format(R"({{"brim": 1, "name": "p", "frames": 1, "bodies": [
      {{"kind": "rigid", "name": "a", "material": "{}", "shape": {{"kind": "sphere", "radius": 0.1}}}}]}})",
                                  material));
  };
  for (const char* word : {"/bodies/0/material", "must be one of: default, fluid",
                           R"("materials": {"rubber": {"preset": "rubber"}})", "presets: cotton, rubber, steel"})
    EXPECT_NE(text("rubber").find(word), std::string::npos) << text("rubber");
  EXPECT_NE(text("rubbr").find("\"preset\": \"rubber\""), std::string::npos) << text("rubbr");
  EXPECT_EQ(text("water").find("preset"), std::string::npos) << "water is a preset, but of no material";
}

TEST(Errors, OfAFileAreToldAllAtOnce) {
  const char* const text = R"({"brim": 1, "name": "p", "frames": 1,
    "world": {"time_step": -1},
    "bodies": [
    {"kind": "rigid", "name": "a", "densty": 3, "shape": {"kind": "sphere", "radius": -1}},
    {"kind": "rigid", "name": "b", "material": "ice", "shape": {"kind": "sphere", "radius": 1}},
    {"kind": "jely", "name": "c"}],
    "expect": [{"metric": "speed"}]})";
  try {
    scene_of(text);
    FAIL();
  } catch (const InputErrors& e) {
    ASSERT_EQ(e.messages().size(), 6u) << e.what();
    const char* places[] = {"scene.json:2: /world/time_step",       "scene.json:4: /bodies/0/densty",
                            "scene.json:4: /bodies/0/shape/radius", "scene.json:6: /bodies/2/kind",
                            "scene.json:5: /bodies/1/material",     "scene.json:7: /expect/0"};
    for (const char* place : places) EXPECT_NE(std::string(e.what()).find(place), std::string::npos) << place;
    EXPECT_NE(std::string(e.what()).find("--plugin"), std::string::npos);
  }
}

TEST(Errors, OfFormulasPresetsAndIncludesAreToldWithTheRestAndOnce) {
  const char* const text = R"({"brim": 1, "name": "p", "frames": 1,
    "parameters": {"a": "=b+1", "c": "=2*a", "d": {"description": "none"}},
    "world": {"voxel_size": "=c", "time_stp": 1},
    "include": [{"file": "missing_1.json"}, {"file": "missing_2.json"}],
    "materials": {"x": {"preset": "stel", "frction": 2}},
    "bodies": [
    {"kind": "rigid", "name": "a", "shape": {"kind": "sphere", "radius": "=q*2"}},
    {"kind": "rigid", "name": "b", "preset": "boen", "shape": {"kind": "box", "size": [1, "=d", -1]}}]})";
  try {
    scene_of(text);
    FAIL();
  } catch (const InputErrors& e) {
    const char* places[] = {"scene.json:2: /parameters/a: \"=b+1\"",
                            "scene.json:2: /parameters/d: the key \"value\"",
                            "scene.json:3: /world/time_stp",
                            "missing_1.json",
                            "missing_2.json",
                            "scene.json:5: /materials/x/preset",
                            "scene.json:5: /materials/x/frction",
                            "scene.json:7: /bodies/0/shape/radius: \"=q*2\"",
                            "scene.json:8: /bodies/1/preset",
                            "scene.json:8: /bodies/1/shape/size/2"};
    EXPECT_EQ(e.messages().size(), std::size(places)) << e.what();
    for (const char* place : places)
      EXPECT_NE(std::string(e.what()).find(place), std::string::npos) << place << "\n" << e.what();
  }
}

}  // namespace
}  // namespace brim::parameters_test
