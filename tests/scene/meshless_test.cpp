#include <gtest/gtest.h>

#include <cmath>

#include "brim/core/error.h"
#include "brim/scene/scene.h"

namespace brim::meshless_test {
namespace {

World build(const std::string& keys) {
  return build_world(parse_scene(R"({"brim": 1, "name": "frames", "duration": 1, "bodies": [
      {"kind": "meshless", "name": "soft", )" +
                                     keys + "}]}",
                                 "scene.json"));
}

std::string message(const std::string& keys) {
  try {
    build(keys);
    return "";
  } catch (const InputError& e) {
    return e.what();
  }
}

const std::string kBox = R"("shape": {"kind": "box", "size": [0.4, 0.3, 0.2]})";

TEST(MeshlessScenes, ABoxIsFilledWithFramesThatCarryItsMass) {
  const World w = build(kBox + R"(, "frame_spacing": 0.1, "voxel_size": 0.04, "density": 500,
                                   "transform": {"position": [0, 0, 3]})");
  EXPECT_EQ(w.body(0).kind(), "meshless");
  EXPECT_NEAR(w.body(0).mass(), 500 * 0.024, 0.03 * 12);
  EXPECT_NEAR(w.body(0).bounds(0).center().z(), 3.0, 1e-6);
  EXPECT_GT(w.body(0).display().triangles.size(), 10u);
}

TEST(MeshlessScenes, ThinBodiesHaveVoxelsThatShowHowThinTheyAre) {
  const auto voxel = [](const std::string& keys) { return build(keys).body(0).part(0).voxel_size; };
  EXPECT_DOUBLE_EQ(voxel(kBox + R"(, "frame_spacing": 0.05)"), 0.025);
  const std::string domino = R"("shape": {"kind": "box", "size": [0.08, 0.25, 0.5]}, "frame_spacing": 0.07)";
  EXPECT_DOUBLE_EQ(voxel(domino), 0.01);
  EXPECT_DOUBLE_EQ(voxel(domino + R"(, "voxel_size": 0.03)"), 0.03);
  // No more than 20,000 particles.
  EXPECT_NEAR(voxel(R"("shape": {"kind": "box", "size": [2, 2, 0.25]}, "frame_spacing": 0.15)"), std::cbrt(1.0 / 20000),
              1e-12);
}

TEST(MeshlessScenes, WhatIsShownBendsBetweenTheCornersOfTheShape) {
  const World w = build(kBox + R"(, "frame_spacing": 0.1)");
  const Display& display = w.body(0).display();
  std::vector<Vec3f> x(display.vertices);
  w.body(0).display_positions(x);
  Vec3f lo = x[0], hi = x[0];
  for (const Vec3f& p : x) lo = lo.cwiseMin(p), hi = hi.cwiseMax(p);
  EXPECT_LT((hi - lo - Vec3f(0.4f, 0.3f, 0.2f)).norm(), 1e-5f) << "the shape is the same";
  EXPECT_LT(display.vertices, 300u);
  for (const Triangle& t : display.triangles)
    for (int k = 0; k < 3; ++k)
      EXPECT_LE((x[static_cast<std::size_t>(t[k])] - x[static_cast<std::size_t>(t[(k + 1) % 3])]).norm(), 0.1f + 1e-6f);
}

TEST(MeshlessScenes, BadInputIsRefusedWithAMessage) {
  const auto expect = [](const std::string& keys, const std::vector<std::string>& words) {
    const std::string text = message(keys);
    for (const std::string& word : words)
      EXPECT_NE(text.find(word), std::string::npos) << keys << ": \"" << text << "\" lacks \"" << word << "\"";
  };
  expect(R"("frame_spacing": 0.1)", {"\"shape\" is missing"});
  expect(kBox, {"\"frame_spacing\" is missing"});
  expect(kBox + R"(, "frame_spacing": 0)", {"/bodies/0/frame_spacing", "above 0"});
  expect(kBox + R"(, "frame_spacing": 2)", {"/bodies/0/frame_spacing", "largest extent"});
  expect(kBox + R"(, "frame_spacing": 1e-4)", {"/bodies/0/frame_spacing", "memory_limit"});
  expect(kBox + R"(, "frame_spacing": 0.1, "voxel_size": 1e-5)", {"/bodies/0", "memory_limit"});
  expect(kBox + R"(, "frame_spacing": 0.1, "poisson_ratio": 0.5)", {"poisson_ratio", "below 0.5"});
  expect(R"("shape": {"kind": "plane"}, "frame_spacing": 0.1)", {"no finite volume"});
  expect(kBox + R"(, "frame_spacing": 0.1, "lattice_spacing": 0.1)", {"unknown key"});
}

}  // namespace
}  // namespace brim::meshless_test
