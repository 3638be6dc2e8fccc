#include <gtest/gtest.h>

#include <string>

#include "brim/core/error.h"
#include "brim/scene/scene.h"

/// Work and memory are bounded, and the bound is said.
namespace brim::bounds_test {
namespace {

std::string message(const auto& f) {
  try {
    f();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

/// Boxes in one place on a floor.
std::string crowd(int boxes, const std::string& world) {
  std::string bodies = R"({"kind": "obstacle", "name": "floor", "shape": {"kind": "plane"}})";
  for (int i = 0; i < boxes; ++i)
    bodies +=
        fmt::format(R"(, {{"kind": "rigid", "name": "box{}", "shape": {{"kind": "box", "size": [1, 1, 1]}}}})", i);
  return R"({"brim": 1, "name": "test", "frames": 1, "world": {)" + world + R"(}, "bodies": [)" + bodies + "]}";
}

std::string step(const std::string& text) {
  World world = build_world(parse_scene(text, "scene.json"));
  return message([&] { world.step(); });
}

TEST(Bounds, BodiesInOnePlaceAreRefusedWhereTheyPassTheMemoryLimit) {
  EXPECT_EQ(step(crowd(8, "")), "");
  EXPECT_NE(step(crowd(8, R"("response": "penalty", "memory_limit": 1e6)"))
                .find("contacts at one time, more than memory_limit"),
            std::string::npos);
  EXPECT_EQ(step(crowd(8, R"("response": "constraint")")), "");
  EXPECT_NE(step(crowd(8, R"("response": "constraint", "memory_limit": 2e4)")).find("constraint rows at one time"),
            std::string::npos);
  EXPECT_NE(step(crowd(40, R"("memory_limit": 1e4)")).find("pairs of bodies that may touch"), std::string::npos);
}

TEST(Bounds, BodiesThatStartWithinEachOtherAreToldUnderBothResponses) {
  const auto codes = [](const char* z, const char* response) {
    World world = build_world(
        parse_scene(fmt::format(R"({{"brim": 1, "name": "t", "frames": 1, "world": {{"response": "{}"}}, "bodies": [
          {{"kind": "obstacle", "name": "floor", "shape": {{"kind": "plane"}}}},
          {{"kind": "rigid", "name": "box", "shape": {{"kind": "box", "size": [1, 1, 1]}}, "transform": {{"position": [0, 0, {}]}}}}]}})",
                                response, z),
                    "scene.json"));
    int first = 0, later = 0;
    for (const Warning& w : world.step().warnings) first += w.code == "start_overlap";
    for (const Warning& w : world.step().warnings) later += w.code == "start_overlap";
    return std::pair(first, later);
  };
  for (const char* response : {"penalty", "constraint"}) {
    EXPECT_EQ(codes("0.5", response), std::pair(0, 0)) << response;
    EXPECT_EQ(codes("0.2", response), std::pair(1, 0)) << response;
    EXPECT_EQ(codes("-2", response), std::pair(1, 0)) << response;
  }
}

TEST(Bounds, BodiesThatStartDeepWithinEachOtherAreToBePlacedApart) {
  World world =
      build_world(parse_scene(R"({"brim": 1, "name": "t", "frames": 1, "world": {"response": "penalty"}, "bodies": [
          {"kind": "obstacle", "name": "floor", "shape": {"kind": "plane"}},
          {"kind": "rigid", "name": "box", "shape": {"kind": "box", "size": [1, 1, 1]},
           "transform": {"position": [0, 0, -2]}}]})",
                              "scene.json"));
  int saturated = 0;
  for (const Warning& w : world.step().warnings) {
    if (w.code != "saturation") continue;
    ++saturated;
    EXPECT_NE(w.message.find("at the start"), std::string::npos) << w.message;
    EXPECT_NE(w.message.find("place them apart"), std::string::npos) << w.message;
    EXPECT_EQ(w.message.find("time_step"), std::string::npos) << w.message;
  }
  EXPECT_EQ(saturated, 1);
}

TEST(Bounds, KeysAreShortAndPlain) {
  const auto read = [](const std::string& key) {
    return message([&] { parse_scene("{\"" + key + "\": 1}", "scene.json"); });
  };
  const std::string much = read(std::string(30'000'000, 'k'));
  EXPECT_NE(much.find("a key has at most 256 bytes"), std::string::npos);
  EXPECT_LT(much.size(), 300u);
  EXPECT_NE(read(std::string(256, 'k')).find("unknown key"), std::string::npos);
  EXPECT_NE(read(std::string(257, 'k')).find("at most 256"), std::string::npos);
  const std::string odd = read("a\\u001b[31m\\u0000b");
  EXPECT_NE(odd.find("\"a\\u001b[31m\\u0000b\" is not allowed"), std::string::npos) << odd;
}

TEST(Bounds, NamesOfBodiesArePlain) {
  const std::string scene = R"({"brim": 1, "name": "t", "frames": 1, "bodies": [{"kind": "rigid", "name": "a\u001b[31m",
    "shape": {"kind": "box", "size": [1, 1, 1]}}]})";
  const std::string said = message([&] { parse_scene(scene, "scene.json"); });
  EXPECT_NE(said.find("scene.json:1: /bodies/0/name: \"a\\u001b[31m\" is not allowed"), std::string::npos) << said;
}

}  // namespace
}  // namespace brim::bounds_test
