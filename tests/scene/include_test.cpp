#include "brim/scene/include.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "brim/core/error.h"
#include "brim/scene/scene.h"
#include "support/sensing.h"

namespace brim::include_test {
namespace {

namespace fs = std::filesystem;

class Include : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("brim_include_" + std::to_string(::getpid()));
    fs::create_directories(folder_ / "parts");
    write("parts/tet.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
    write("parts/table.json", R"({"brim": 1, "name": "table", "frames": 1, "parameters": {"height": 0.7},
      "materials": {"wood": {"friction": 0.4}}, "pairs": [{"materials": ["wood", "wood"], "friction": 0.3}],
      "bodies": [
        {"kind": "obstacle", "name": "top", "material": "wood", "shape": {"kind": "box", "size": [1, 2, 0.1]},
         "transform": {"position": [1, 0, "=height"]}},
        {"kind": "rigid", "name": "tet", "shape": {"kind": "mesh", "file": "tet.obj"}, "velocity": [1, 0, 0]},
        {"kind": "cloth", "name": "sheet", "grid": {"size": [1, 1], "cells": [4, 4]},
         "constraints": [{"select": {"kind": "sphere", "center": [0.5, 0.5, 0], "radius": 0.3}}]}]})");
  }
  void TearDown() override { fs::remove_all(folder_); }
  void write(const char* name, const std::string& text) const { std::ofstream(folder_ / name) << text; }
  Scene scene_of(const std::string& include) const {
    return parse_scene(R"({"brim": 1, "name": "room", "frames": 1, "world": {"response": "penalty"}, "bodies": [
      {"kind": "obstacle", "name": "floor", "shape": {"kind": "plane"}}], "include": )" +
                           include + "}",
                       (folder_ / "room.json").string());
  }
  std::string message_of(const std::string& include) const {
    try {
      build_world(scene_of(include));
      return "";
    } catch (const InputError& e) {
      return e.what();
    }
  }
  fs::path folder_;
};

TEST_F(Include, BodiesAreNamedAndMovedAndMaterialsAreKeptApart) {
  const Scene s = scene_of(R"([{"file": "parts/table.json", "prefix": "l_", "set": {"height": 0.5},
    "transform": {"position": [10, 0, 1], "rotation": {"axis": [0, 0, 1], "degrees": 90}}},
    {"file": "parts/table.json", "prefix": "r_"}])");
  const World world = build_world(s);
  ASSERT_EQ(world.body_count(), 7);
  EXPECT_EQ(world.body(0).name(), "floor");
  EXPECT_EQ(world.body(1).name(), "l_top");
  // (1, 0, 0.5) turned about z by 90 degrees is (0, 1, 0.5).
  EXPECT_NEAR((Vec3(world.q(1)[0], world.q(1)[1], world.q(1)[2]) - Vec3(10, 1, 1.5)).norm(), 0.0, 1e-12);
  EXPECT_NEAR(world.q(4)[2], 0.7, 1e-12);
  EXPECT_NEAR((Vec3(world.v(2)[0], world.v(2)[1], world.v(2)[2]) - Vec3(0, 1, 0)).norm(), 0.0, 1e-12);
  const Json& sphere = s.document->root["bodies"][3]["constraints"][0]["select"];
  EXPECT_NEAR(sphere["center"][0].get<double>(), 9.5, 1e-12);
  EXPECT_TRUE(s.materials.contains("l_wood") && s.materials.contains("r_wood"));
  EXPECT_EQ(s.world.pair_materials.size(), 2u);
}

TEST_F(Include, MaterialsOfAFileAreThoseOfItsBodiesThatNameNone) {
  write("parts/wet.json", R"({"materials": {"fluid": {"friction": 0.2}, "default": {"friction": 0.4}}, "bodies": [
    {"kind": "particle_fluid", "name": "water", "spacing": 0.1, "shape": {"kind": "box", "size": [1, 1, 1]}},
    {"kind": "rigid", "name": "ball", "shape": {"kind": "sphere", "radius": 0.5}}]})");
  const Scene s = scene_of(R"([{"file": "parts/wet.json", "prefix": "l_"}])");
  const Json& bodies = s.document->root["bodies"];
  EXPECT_EQ(bodies.at(bodies.size() - 2)["material"], "l_fluid");
  EXPECT_EQ(bodies.back()["material"], "l_default");
}

TEST_F(Include, TheKeptTextStandsByItself) {
  const Scene s = scene_of(R"([{"file": "parts/table.json", "prefix": "l_"}])");
  const Scene again = parse_scene(s.text, (folder_ / "room.json").string());
  EXPECT_EQ(again.document->root, s.document->root);
  EXPECT_EQ(build_world(again).body_count(), 4);
}

TEST_F(Include, MistakesAreSaidWhereTheyStand) {
  EXPECT_NE(message_of(R"([{"file": "parts/table.json"}, {"file": "parts/table.json"}])").find("parts/table.json:4"),
            std::string::npos)
      << "names that are there twice";
  EXPECT_NE(message_of(R"([{"file": "none.json"}])").find("/include/0/file"), std::string::npos);
  EXPECT_NE(message_of(R"([{"file": "parts/table.json", "prefx": "a"}])").find("did you mean \"prefix\"?"),
            std::string::npos);
  EXPECT_NE(message_of(R"([{"file": "parts/table.json", "set": {"hight": 1}}])").find("did you mean \"height\"?"),
            std::string::npos);
  const std::string computed = message_of(R"([{"file": "=nope"}, {"file": "none.json"}])");
  EXPECT_NE(computed.find("there is no parameter \"nope\""), std::string::npos) << computed;
  EXPECT_NE(computed.find("none.json"), std::string::npos) << computed;
  EXPECT_EQ(std::count(computed.begin(), computed.end(), '\n'), 1) << "one line each: " << computed;
  write("parts/wrong.json",
        "{\"brim\": 1,\n \"bodies\": [\n {\"kind\": \"rigid\", \"name\": \"a\", \"shape\": {\"kind\": "
        "\"sphere\", \"radius\": -1}}]}");
  EXPECT_NE(message_of(R"([{"file": "parts/wrong.json"}])").find("wrong.json:3: /bodies/0/shape/radius: -1"),
            std::string::npos)
      << message_of(R"([{"file": "parts/wrong.json"}])");
  write("self.json", R"({"include": [{"file": "self.json"}]})");
  EXPECT_NE(message_of(R"([{"file": "self.json"}])").find("includes itself"), std::string::npos);
  write("turned.json", R"({"bodies": [{"kind": "rigid", "name": "a", "shape": {"kind": "sphere", "radius": 1},
    "repeat": {"count": [2, 1, 1]}}]})");
  const char* const turned =
      R"([{"file": "turned.json", "transform": {"rotation": {"axis": [0, 0, 1], "degrees": 9}}}])";
  EXPECT_NE(message_of(turned).find("move it, not turn it"), std::string::npos) << message_of(turned);
}

TEST_F(Include, CopiesInACircleMoveAndTurn) {
  write("ring.json", R"({"bodies": [{"kind": "rigid", "name": "a", "shape": {"kind": "sphere", "radius": 0.1},
    "transform": {"position": [1, 0, 0]}, "repeat": {"around": {"count": 4}}}]})");
  const World world = build_world(scene_of(R"([{"file": "ring.json", "transform": {"position": [10, 0, 2],
    "rotation": {"axis": [1, 0, 0], "degrees": 90}}}])"));
  ASSERT_EQ(world.body_count(), 5);
  const Vec3 places[] = {{11, 0, 2}, {10, 0, 3}, {9, 0, 2}, {10, 0, 1}};
  for (int k = 0; k < 4; ++k) {
    const std::span<const double> q = world.q(1 + k);
    EXPECT_LT((Vec3(q[0], q[1], q[2]) - places[k]).norm(), 1e-12) << k;
  }
}

TEST_F(Include, SensorsRegionsOfFiltersAndFieldsOfAirComeAlong) {
  write("parts/plate.json", R"({"brim": 1, "name": "plate", "frames": 1,
    "bodies": [
      {"kind": "obstacle", "name": "plate", "shape": {"kind": "box", "size": [1, 1, 0.2]}, "transform": {"position": [0, 0, -0.1]}},
      {"kind": "rigid", "name": "ball", "shape": {"kind": "sphere", "radius": 0.2}, "transform": {"position": [0.2, 0, 0.19]}}],
    "groups": {"things": ["ball"]},
    "filters": [{"between": ["plate", "things"], "region": {"kind": "sphere", "center": [5, 0, 0], "radius": 0.1}}],
    "attachments": [{"name": "string", "body": "ball", "point": [0.2, 0, 0.19], "stiffness": 1}],
    "forces": [{"name": "vortex", "wind": {"field": {"velocity": ["-y", "x", "0"], "transform": {"position": [1, 0, 0]}}}}],
    "sensors": [
      {"name": "weight", "kind": "force", "body": "plate", "with": ["things"], "region": {"kind": "sphere", "center": [0.2, 0, 0], "radius": 0.3}},
      {"name": "map", "kind": "pressure", "body": ["plate"], "grid": {"origin": [-0.5, -0.5, 0], "x": [1, 0, 0], "y": [0, 1, 0]}},
      {"name": "height", "kind": "distance", "body": "ball", "point": [0.2, 0, 0.19], "to": "plate", "to_point": [0.2, 0, 0]},
      {"name": "pull", "kind": "link", "link": "string"}]})");
  const Scene s = scene_of(R"([{"file": "parts/plate.json", "prefix": "l_",
      "transform": {"position": [10, 0, 0], "rotation": {"axis": [0, 0, 1], "degrees": 90}}},
    {"file": "parts/plate.json", "prefix": "r_", "transform": {"position": [-10, 0, 0]}}])");
  const Json& root = s.document->root;
  const auto vec = [](const Json& v) { return Vec3(v[0].get<double>(), v[1].get<double>(), v[2].get<double>()); };
  ASSERT_EQ(root["sensors"].size(), 8u);
  const Json &weight = root["sensors"][0], &map = root["sensors"][1], &height = root["sensors"][2];
  EXPECT_EQ(weight["name"], "l_weight");
  EXPECT_EQ(weight["body"], "l_plate");
  EXPECT_EQ(weight["with"], Json::parse(R"(["l_things"])"));
  EXPECT_NEAR((vec(weight["region"]["center"]) - Vec3(10, 0.2, 0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((vec(weight["about"]) - Vec3(10, 0, 0)).norm(), 0.0, 1e-12) << "the origin of its own scene";
  EXPECT_NEAR((vec(map["grid"]["origin"]) - Vec3(10.5, -0.5, 0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((vec(map["grid"]["x"]) - Vec3(0, 1, 0)).norm(), 0.0, 1e-12);
  EXPECT_EQ(height["to"], "l_plate");
  EXPECT_EQ(root["sensors"][3]["link"], "l_string");
  EXPECT_EQ(root["sensors"][7]["link"], "r_string");
  EXPECT_NEAR((vec(root["filters"][0]["region"]["center"]) - Vec3(10, 5, 0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((vec(root["forces"][0]["wind"]["field"]["transform"]["position"]) - Vec3(10, 1, 0)).norm(), 0.0, 1e-12);
  World world = build_world(s);
  for (int i = 0; i < 30; ++i) world.step();
  // The two do the same, turned, and their sensors read the same.
  const auto expect_same = [&](const std::string& sensor, const std::string& channel, double least, double tolerance) {
    const double l = testing::reading(world, "l_" + sensor, channel),
                 r = testing::reading(world, "r_" + sensor, channel);
    EXPECT_GT(r, least) << sensor;
    EXPECT_NEAR(l, r, tolerance * std::abs(r)) << sensor;
  };
  expect_same("weight", "normal", 100.0, 1e-3);
  expect_same("map", "force", 100.0, 1e-3);
  expect_same("height", "distance", 0.1, 1e-6);
  const Scene again = parse_scene(s.text, (folder_ / "room.json").string());
  EXPECT_EQ(again.document->root, root);
}

TEST_F(Include, WhatIsWiredUpComesAlong) {
  write("parts/door.json", R"({"brim": 1, "name": "door", "frames": 1,
    "bodies": [
      {"kind": "obstacle", "name": "post", "shape": {"kind": "box", "size": [0.1, 0.1, 2]}, "transform": {"position": [0, 0, 1]}},
      {"kind": "rigid", "name": "leaf", "shape": {"kind": "box", "size": [0.8, 0.04, 1.8]}, "transform": {"position": [0.5, 0, 1]}},
      {"kind": "rigid", "name": "bell", "shape": {"kind": "sphere", "radius": 0.05}, "transform": {"position": [0.8, 0.2, 1]}}],
    "groups": {"wood": ["post", "lea*"]},
    "filters": [{"between": ["wood", "bell"]}],
    "joints": [{"name": "hinge", "kind": "revolute", "body": "leaf", "to": "post", "position": [0.1, 0, 1], "axis": [1, 0, 0]}],
    "attachments": [{"name": "string", "body": "bell", "to": "leaf", "point": [0.8, 0.2, 1], "to_point": [0.8, 0, 1.5]}],
    "forces": [{"name": "draught", "wind": {"velocity": [2, 0, 0]}, "acceleration": [0, 1, 0]},
               {"name": "pull", "bodies": ["bell"], "attractor": {"strength": 3}}]})");
  const Scene s = scene_of(R"([{"file": "parts/door.json", "prefix": "l_",
      "transform": {"position": [10, 0, 0], "rotation": {"axis": [0, 0, 1], "degrees": 90}}},
    {"file": "parts/door.json", "prefix": "r_"}])");
  const Json& root = s.document->root;
  const auto vec = [](const Json& v) { return Vec3(v[0].get<double>(), v[1].get<double>(), v[2].get<double>()); };
  EXPECT_EQ(root["groups"]["l_wood"], Json::parse(R"(["l_post", "l_lea*"])"));
  EXPECT_EQ(root["filters"][1]["between"], Json::parse(R"(["r_wood", "r_bell"])"));
  const Json& hinge = root["joints"][0];
  EXPECT_EQ(hinge["name"], "l_hinge");
  EXPECT_EQ(hinge["body"], "l_leaf");
  EXPECT_EQ(hinge["to"], "l_post");
  EXPECT_NEAR((vec(hinge["position"]) - Vec3(10, 0.1, 1)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((vec(hinge["axis"]) - Vec3(0, 1, 0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((vec(root["attachments"][0]["to_point"]) - Vec3(10, 0.8, 1.5)).norm(), 0.0, 1e-12);
  EXPECT_EQ(root["attachments"][1]["point"], Json::parse("[0.8, 0.2, 1]"));
  EXPECT_EQ(root["forces"][0]["bodies"], Json::parse(R"(["l_leaf", "l_bell"])")) << "those of its file that can move";
  EXPECT_NEAR((vec(root["forces"][0]["wind"]["velocity"]) - Vec3(0, 2, 0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((vec(root["forces"][0]["acceleration"]) - Vec3(-1, 0, 0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((vec(root["forces"][1]["attractor"]["center"]) - Vec3(10, 0, 0)).norm(), 0.0, 1e-12);
  World world = build_world(s);
  ASSERT_EQ(world.body_count(), 7);
  for (int i = 0; i < 5; ++i) world.step();
  // The two doors do the same, turned: the wind blows along each.
  EXPECT_NEAR(world.q(2)[2], world.q(5)[2], 1e-6);
  const Scene again = parse_scene(s.text, (folder_ / "room.json").string());
  EXPECT_EQ(again.document->root, root);
}

TEST_F(Include, EditsOfATimelineComeAlong) {
  write("parts/toss.json", R"({"brim": 1, "name": "toss", "frames": 1, "world": {"time_step": 0.01},
    "materials": {"ice": {"friction": 0.01}},
    "bodies": [
      {"kind": "rigid", "name": "ball", "shape": {"kind": "sphere", "radius": 0.1}, "transform": {"position": [0, 0, 1]}},
      {"kind": "rigid", "name": "brick", "shape": {"kind": "box", "size": [0.4, 0.2, 0.1]}, "transform": {"position": [1, 0, 1]}},
      {"kind": "rigid", "name": "lamp", "shape": {"kind": "sphere", "radius": 0.1}, "transform": {"position": [2, 0, 1]}}],
    "attachments": [{"name": "string", "body": "lamp", "point": [2, 0, 1.1]}],
    "timeline": [
      {"at": 0.02, "freeze": "b*"},
      {"at": 0.04, "move": "brick", "offset": [0.5, 0, 0], "rotation": {"axis": [1, 0, 0], "degrees": 90}},
      {"at": 0.06, "thaw": "b*"},
      {"at": 0.06, "set_velocity": "ball", "velocity": [1, 0, 0], "angular_velocity": [0, 2, 0]},
      {"at": 0.06, "set_material": "ball", "material": "ice"},
      {"at": 0.06, "detach": "string"},
      {"at": 0.06, "gravity": [0, 0, 0]}]})");
  const Scene s = scene_of(R"([{"file": "parts/toss.json", "prefix": "l_",
      "transform": {"position": [10, 0, 0], "rotation": {"axis": [0, 0, 1], "degrees": 90}}},
    {"file": "parts/toss.json", "prefix": "r_"}])");
  const Json& list = s.document->root["timeline"];
  const auto vec = [](const Json& v) { return Vec3(v[0].get<double>(), v[1].get<double>(), v[2].get<double>()); };
  ASSERT_EQ(list.size(), 12u) << "gravity is of the world, which stays behind";
  EXPECT_EQ(list[0]["freeze"], "l_b*");
  EXPECT_EQ(list[1]["move"], "l_brick");
  EXPECT_NEAR((vec(list[1]["offset"]) - Vec3(0, 0.5, 0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((vec(list[3]["velocity"]) - Vec3(0, 1, 0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((vec(list[3]["angular_velocity"]) - Vec3(-2, 0, 0)).norm(), 0.0, 1e-12);
  EXPECT_EQ(list[4]["material"], "l_ice");
  EXPECT_EQ(list[5]["detach"], "l_string");
  EXPECT_EQ(list[7]["offset"], Json::parse("[0.5, 0, 0]"));
  World world = build_world(s);
  while (world.state().time < 0.3) world.step();
  // The two do the same, one of them turned.
  const Mat3 R = rotation_from_vector(Vec3(0, 0, 0.5 * std::numbers::pi)).toRotationMatrix();
  const int left = 1, right = 4;  // after the floor
  for (int b = 0; b < 3; ++b) {
    SCOPED_TRACE(world.body(right + b).name());
    const Vec3 l(world.q(left + b).data()), r(world.q(right + b).data());
    EXPECT_NEAR((l - R * r - Vec3(10, 0, 0)).norm(), 0.0, 1e-6);
    const Quat ql(world.q(left + b)[3], world.q(left + b)[4], world.q(left + b)[5], world.q(left + b)[6]),
        qr(world.q(right + b)[3], world.q(right + b)[4], world.q(right + b)[5], world.q(right + b)[6]);
    EXPECT_NEAR((ql.toRotationMatrix() - R * qr.toRotationMatrix()).norm(), 0.0, 1e-6);
  }
  EXPECT_NEAR(world.q(right)[0], 0.24, 0.02) << "the ball was pushed";
  EXPECT_NEAR(world.q(right + 1)[0], 1.5, 1e-3) << "the brick was moved";
  EXPECT_LT(world.q(right + 2)[2], 0.9) << "the lamp fell";
  const Scene again = parse_scene(s.text, (folder_ / "room.json").string());
  EXPECT_EQ(again.document->root, s.document->root);
}

TEST_F(Include, MistakesInWhatIsWiredUpAreSaidWhereTheyStand) {
  const std::string body =
      R"({"brim": 1, "bodies": [{"kind": "rigid", "name": "a", "shape": {"kind": "sphere", "radius": 1}}],
)";
  write("parts/link.json", body + R"("attachments": [{"name": "x", "body": "b", "point": [0, 0, 0]}]})");
  std::string text = message_of(R"([{"file": "parts/link.json", "prefix": "p_"}])");
  EXPECT_NE(text.find("link.json:2: /attachments/0"), std::string::npos) << text;
  EXPECT_NE(text.find("p_b"), std::string::npos) << text;
  write("parts/link.json", body + R"("attachments": [{"name": "x", "body": "a", "pint": [0, 0, 0]}]})");
  text = message_of(R"([{"file": "parts/link.json", "prefix": "p_"}])");
  EXPECT_NE(text.find("link.json:2: /attachments/0"), std::string::npos) << text;
  write(
      "parts/link.json",
      body +
          R"("forces": [{"name": "f", "force": [1, 0, 0], "region": {"kind": "box", "lo": [0, 0, 0], "hi": [1, 1, 1]}}]})");
  text = message_of(R"([{"file": "parts/link.json", "transform": {"rotation": {"axis": [0, 0, 1], "degrees": 9}}}])");
  EXPECT_NE(text.find("link.json:2: /forces/0: a region that is a box"), std::string::npos) << text;
  write("parts/link.json", body + R"("groups": {"g": ["a"]}})");
  write("parts/other.json", R"({"bodies": [{"kind": "rigid", "name": "c", "shape": {"kind": "sphere", "radius": 1}}],
    "groups": {"g": ["c"]}})");
  text = message_of(R"([{"file": "parts/link.json"}, {"file": "parts/other.json"}])");
  EXPECT_NE(text.find("the group \"g\" is there already"), std::string::npos) << text;
}

}  // namespace
}  // namespace brim::include_test
