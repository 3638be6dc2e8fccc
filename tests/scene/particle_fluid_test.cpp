#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "brim/core/error.h"
#include "brim/scene/scene.h"

namespace brim::particle_fluid_test {
namespace {

std::string scene_with(const std::string& fluid, const std::string& world = R"({"voxel_size": 0.05})") {
  return R"({"brim": 1, "name": "s", "duration": 0.1, "world": )" + world + R"(, "bodies": [
    {"kind": "particle_fluid", "name": "water", )" +
         fluid + "}]}";
}

std::string message(const std::string& text) {
  try {
    build_world(parse_scene(text));
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

constexpr const char* kBox = R"("shape": {"kind": "box", "size": [1, 0.5, 0.5]}, "spacing": 0.1)";

TEST(ParticleFluidScene, FillsAShapeWithOneParticleForEachCube) {
  const World box = build_world(parse_scene(scene_with(kBox)));
  EXPECT_EQ(box.v(0).size(), 3u * 250u);
  EXPECT_NEAR(box.body(0).mass(), 250.0, 1e-9);
}

TEST(ParticleFluidScene, MassIsDensityTimesTheVolumeOfTheShape) {
  const auto mass = [](const std::string& shape) {
    return build_world(parse_scene(scene_with(R"("spacing": 0.04, "density": 800, "shape": )" + shape, "{}")))
        .body(0)
        .mass();
  };
  const double pi = std::numbers::pi;
  const auto expect = [&](const std::string& shape, double volume) {
    EXPECT_NEAR(mass(shape), 800.0 * volume, 800e-9 * volume) << shape;
  };
  expect(R"({"kind": "sphere", "radius": 0.1})", 4.0 / 3.0 * pi * 1e-3);
  expect(R"({"kind": "box", "size": [0.4, 0.4, 0.05]})", 0.008);
  expect(R"({"kind": "box", "size": [0.46, 0.46, 0.4]})", 0.46 * 0.46 * 0.4);
  expect(R"({"kind": "cylinder", "radius": 0.1, "length": 0.13})", pi * 0.01 * 0.13);
  expect(R"({"kind": "capsule", "radius": 0.1, "length": 0.1})", pi * 0.001 + 4.0 / 3.0 * pi * 1e-3);
  expect(R"({"kind": "l_profile", "leg_x": 0.4, "leg_y": 0.3, "width": 0.15, "length": 0.2})",
         0.2 * 0.15 * (0.4 + 0.3 - 0.15));
}

TEST(ParticleFluidScene, VoxelsOfASpacingFollowTheLatticeThatFits) {
  // Cells of 0.2 x 0.2 x 0.16 m hold less than the asked spacing of voxel_size.
  const World w = build_world(parse_scene(
      scene_with(R"("shape": {"kind": "box", "size": [1, 1, 0.32]}, "spacing": 0.2, "voxel_size": 0.2)", "{}")));
  EXPECT_NEAR(w.body(0).part(0).voxel_size, std::cbrt(0.2 * 0.2 * 0.16), 1e-12);
  EXPECT_NEAR(w.body(0).mass(), 320.0, 1e-9);
}

TEST(ParticleFluidScene, WaterThatStartsInsideABodyIsTold) {
  const auto codes = [](const std::string& carve, const char* z) {
    World world = build_world(
        parse_scene(scene_with(R"("shape": {"kind": "box", "size": [0.6, 0.6, 0.4]}, "spacing": 0.05)" + carve +
                                   R"(}, {"kind": "rigid", "name": "slab", "density": 500, "shape": {"kind": "box",
                       "size": [0.2, 0.2, 0.1]}, "transform": {"position": [0, 0, )" +
                                   z + "]}",
                               "{}"),
                    "scene.json"));
    int first = 0, later = 0;
    for (const Warning& w : world.step().warnings) first += w.code == "start_overlap";
    for (const Warning& w : world.step().warnings) later += w.code == "start_overlap";
    return std::pair(first, later);
  };
  EXPECT_EQ(codes("", "0.2"), std::pair(1, 0));
  EXPECT_EQ(codes("", "0.25"), std::pair(0, 0)) << "it lies on the water";
  EXPECT_EQ(codes(R"(, "carve": [{"kind": "box", "lo": [-0.1, -0.1, 0.15], "hi": [0.1, 0.1, 0.25]}])", "0.2"),
            std::pair(0, 0));
}

TEST(ParticleFluidScene, HasNoFrictionUnlessItsMaterialSaysSo) {
  const auto friction = [](const std::string& more) {
    return build_world(parse_scene(scene_with(std::string(kBox) + more))).body(0).part(0).material.friction;
  };
  EXPECT_EQ(friction(""), 0.0);
  EXPECT_EQ(friction(R"(, "material": "default")"), 0.5);
}

TEST(ParticleFluidScene, JitterStartsParticlesBesideTheLattice) {
  const auto places = [](const std::string& more) {
    const World w = build_world(parse_scene(scene_with(std::string(kBox) + more)));
    return std::vector<double>(w.q(0).begin(), w.q(0).end());
  };
  const std::vector<double> lattice = places(""), moved = places(R"(, "jitter": 0.1)"),
                            other = places(R"(, "jitter": 0.1, "seed": 2)");
  ASSERT_EQ(moved.size(), lattice.size());
  double most = 0.0, sum = 0.0;
  for (std::size_t i = 0; i < lattice.size(); ++i) {
    most = std::max(most, std::abs(moved[i] - lattice[i]));
    sum += moved[i] - lattice[i];
  }
  EXPECT_LE(most, 0.01) << "a tenth of the spacing";
  EXPECT_GT(most, 0.0095);
  EXPECT_LT(std::abs(sum) / static_cast<double>(lattice.size()), 1e-3) << "evenly to all sides";
  EXPECT_NE(moved, other);
  EXPECT_EQ(moved, places(R"(, "jitter": 0.1, "seed": 1)"));
  EXPECT_EQ(lattice, places(R"(, "seed": 7)")) << "without jitter nothing is random";
}

TEST(ParticleFluidScene, ScaleMovesAndTurnsTheParticlesWithTheShape) {
  const World w = build_world(parse_scene(scene_with(
      std::string(kBox) +
      R"(, "transform": {"scale": 2, "position": [0, 0, 5], "rotation": {"axis": [0, 1, 0], "degrees": 90}})")));
  EXPECT_NEAR(w.body(0).mass(), 2000.0, 1e-6);
  EXPECT_NEAR(w.body(0).bounds(0).extent().z(), 2.0, 1e-9);
  EXPECT_NEAR(w.body(0).bounds(0).center().z(), 5.0, 1e-9);
}

TEST(ParticleFluidScene, CarvesRegionsOfItsOwnFrame) {
  // Half of the box; it is scaled and turned with the shape.
  const std::string half = R"(, "carve": [{"kind": "box", "lo": [0, -1, -1], "hi": [1, 1, 1]}])";
  const World w = build_world(parse_scene(scene_with(
      kBox + half +
      R"(, "transform": {"scale": 2, "position": [0, 0, 5], "rotation": {"axis": [0, 1, 0], "degrees": 90}})")));
  EXPECT_EQ(w.v(0).size(), 3u * 125u);
  EXPECT_NEAR(w.body(0).bounds(0).lo.z(), 5.0, 1e-9);
  EXPECT_NEAR(w.body(0).bounds(0).hi.z(), 6.0, 1e-9);
  const std::string all = R"(, "carve": [{"kind": "all"}])";
  EXPECT_NE(message(scene_with(kBox + all)).find("no particle"), std::string::npos);
  const std::string flat = R"(, "carve": [{"kind": "plane", "point": [0, 0, 0], "normal": [0, 0, 0]}])";
  EXPECT_NE(message(scene_with(kBox + flat)).find("/bodies/0/carve/0/normal"), std::string::npos);
}

TEST(ParticleFluidScene, RefusesWhatWouldLeakOrHasNoVolume) {
  EXPECT_NE(message(scene_with(kBox, R"({"voxel_size": 0.2})")).find("/bodies/0/spacing"), std::string::npos);
  EXPECT_NE(message(scene_with(std::string(kBox) + R"(, "voxel_size": 0.2)")).find("leak"), std::string::npos);
  EXPECT_NE(message(scene_with(R"("shape": {"kind": "plane"}, "spacing": 0.1)")).find("volume"), std::string::npos);
  EXPECT_NE(
      message(scene_with(R"("shape": {"kind": "sphere", "radius": 0.1}, "spacing": 0.5)")).find("/bodies/0/spacing"),
      std::string::npos);
  EXPECT_NE(message(scene_with(R"("shape": {"kind": "sphere", "radius": 0.1})")).find("spacing"), std::string::npos);
  EXPECT_NE(message(scene_with(std::string(kBox) + R"(, "viscosity": -1)")).find("/bodies/0/viscosity"),
            std::string::npos);
  EXPECT_NE(message(scene_with(R"("shape": {"kind": "box", "size": [10, 10, 10]}, "spacing": 0.01)",
                               R"({"memory_limit": 1e8})"))
                .find("particles"),
            std::string::npos);
}

}  // namespace
}  // namespace brim::particle_fluid_test
