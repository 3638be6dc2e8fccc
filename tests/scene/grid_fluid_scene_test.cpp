#include <gtest/gtest.h>

#include <numbers>
#include <string>
#include <vector>

#include "brim/core/error.h"
#include "brim/scene/scene.h"

/// Scenes with grid fluids: what is accepted, and what each mistake is told.
namespace brim::grid_fluid_scene_test {
namespace {

std::string message(const std::string& keys) {
  const std::string text =
      R"({"brim": 1, "name": "test", "frames": 1, "bodies": [{"kind": "grid_fluid", "name": "w", )" + keys + "}]}";
  try {
    build_world(parse_scene(text, "scene.json"));
    return "";
  } catch (const InputError& e) {
    return e.what();
  }
}

const char* const kBox = R"("box": {"lo": [0, 0, 0], "hi": [1, 1, 0.5]}, "cell_size": 0.1)";
const char* const kFill = R"("fill": [{"kind": "plane", "point": [0, 0, 0.2], "normal": [0, 0, 1]}])";

TEST(GridFluidScene, GoodScenesAreBuilt) {
  const std::string box = kBox, fill = kFill;
  EXPECT_EQ(message(box + ", " + fill), "");
  EXPECT_EQ(
      message(box + R"(, "fill": [{"kind": "all"}], "carve": [{"kind": "sphere", "center": [0, 0, 0], "radius": 0.3}],
    "open": ["+z", "-x"], "viscosity": 0, "friction": 0.1, "velocity": [0.1, 0, 0])"),
      "");
}

TEST(GridFluidScene, EachMistakeIsToldWithItsPlace) {
  const std::string box = kBox, fill = kFill;
  const std::vector<std::pair<std::string, std::vector<const char*>>> cases = {
      {box, {"/bodies/0", "\"fill\""}},
      {box + R"(, "cell": 0.1)", {"/bodies/0", "did you mean \"cell_size\"?"}},
      {box + R"(, "fill": [])", {"/bodies/0/fill"}},
      {box + R"(, "fill": [{"kind": "corners", "which": [0]}])", {"/bodies/0/fill/0/kind", "cloth"}},
      {box + R"(, "fill": [{"kind": "sphere", "center": [9, 9, 9], "radius": 0.1}])", {"/bodies/0", "no fluid"}},
      {box + R"(, "fill": [{"kind": "box", "lo": [0, 0, 0], "hi": [1, 0, 1]}])", {"/bodies/0/fill/0/hi", "above"}},
      {box + R"(, "fill": [{"kind": "plane", "point": [0, 0, 0], "normal": [0, 0, 0]}])", {"/bodies/0/fill/0/normal"}},
      {box + ", " + fill + R"(, "open": ["up"])", {"/bodies/0/open/0"}},
      {box + ", " + fill + R"(, "density": 0)", {"/bodies/0/density"}},
      {box + ", " + fill + R"(, "transform": {"scale": 2})", {"/bodies/0/transform/scale", "scaled"}},
      {box + ", " + fill + R"(, "transform": {"rotation": {"axis": [0, 0, 1], "degrees": 9}})",
       {"/bodies/0/transform/rotation", "turned"}},
      {R"("box": {"lo": [0, 0, 0], "hi": [1, 1, 0.5]}, "cell_size": 0.3, )" + fill,
       {"/bodies/0/cell_size", "whole number of cells"}},
      {R"("box": {"lo": [0, 0, 0], "hi": [1, -1, 0.5]}, "cell_size": 0.1, )" + fill, {"/bodies/0/box/hi", "above"}},
      {R"("box": {"lo": [0, 0, 0], "hi": [1, 1, 0.5]}, "cell_size": 0.0005, )" + fill,
       {"/bodies/0/cell_size", "memory_limit"}},
  };
  for (const auto& [keys, words] : cases) {
    const std::string text = message(keys);
    EXPECT_NE(text, "") << keys;
    for (const char* word : words) EXPECT_NE(text.find(word), std::string::npos) << keys << "\n  says: " << text;
  }
}

TEST(GridFluidScene, ThinMatterThatIsNoWallIsLiftedByTheWaterThatItDisplaces) {
  struct Case {
    const char* body;
    double volume;
    double miss;
  };
  const double pi = std::numbers::pi;
  for (
      const Case& c : {
          Case{R"("kind": "rod", "points": [[0.22, 0.41, 0.35], [0.62, 0.38, 0.37]], "segments": 16, "radius": 0.02)",
               pi * 4e-4 * 0.402 + 4.0 / 3.0 * pi * 8e-6, 0.06},
          Case{
              R"("kind": "rigid", "shape": {"kind": "sphere", "radius": 0.03}, "transform": {"position": [0.41, 0.43, 0.36]})",
              4.0 / 3.0 * pi * 2.7e-5, 0.04},
          Case{R"("kind": "rigid", "shape": {"kind": "box", "size": [0.3, 0.03, 0.03]},
                   "transform": {"position": [0.41, 0.43, 0.36], "rotation": {"axis": [0, 0, 1], "degrees": 20}})",
               0.3 * 9e-4, 0.04},
      }) {
    World w = build_world(parse_scene(R"({"brim": 1, "name": "t", "frames": 1, "world": {"time_step": 0.01}, "bodies": [
      {"kind": "grid_fluid", "name": "water", "cell_size": 0.05, "box": {"lo": [0, 0, 0], "hi": [0.8, 0.8, 0.8]},
       "fill": [{"kind": "plane", "point": [0, 0, 0.6], "normal": [0, 0, 1]}]}, {"name": "thin", )" +
                                      std::string(c.body) + "}]}"));
    w.freeze(1);
    StepReport r;
    for (int s = 0; s < 30; ++s) r = w.step();
    ASSERT_EQ(r.pairs.size(), 1u) << c.body;
    EXPECT_NEAR(-r.pairs[0].force_on_a.z() / (9810.0 * c.volume), 1.0, c.miss) << c.body;
    EXPECT_LT(r.kinetic_energy, 1e-6) << "by contact, water ran at metres a second: " << c.body;
  }
}

TEST(GridFluidScene, ARodTwiceAsHeavyAsWaterSinks) {
  World w = build_world(parse_scene(R"({"brim": 1, "name": "t", "frames": 1, "world": {"time_step": 0.01}, "bodies": [
      {"kind": "grid_fluid", "name": "water", "cell_size": 0.05, "box": {"lo": [0, 0, 0], "hi": [0.8, 0.8, 0.8]},
       "fill": [{"kind": "plane", "point": [0, 0, 0.4], "normal": [0, 0, 1]}]},
      {"kind": "rod", "name": "rod", "points": [[0.22, 0.41, 0.45], [0.62, 0.38, 0.45]], "segments": 16, "radius": 0.02,
       "linear_density": 2.5}]})"));
  for (int s = 0; s < 80; ++s) ASSERT_TRUE(w.step().ok);
  double lowest = 1.0;
  for (std::size_t i = 2; i < w.q(1).size(); i += 3) lowest = std::min(lowest, w.q(1)[i]);
  EXPECT_LT(lowest, 0.1) << "by contact it stayed on the surface";
}

TEST(GridFluidScene, WaterInAClosedBoxOfThinWallsRests) {
  // Walls of two cells; one of their faces is a third into a cell. Air in the walls let water in.
  const auto wall = [](int i, const std::string& size, const std::string& at) {
    return R"(, {"kind": "obstacle", "name": "wall)" + std::to_string(i) +
           R"(", "voxel_size": 0.02, "shape": {"kind": "box", "size": )" + size + R"(}, "transform": {"position": )" +
           at + "}}";
  };
  std::string walls;
  int n = 0;
  for (const char* side : {"-", ""}) {
    walls += wall(n++, "[0.06, 0.8, 0.8]", std::string("[") + side + "0.37, 0, 0]");
    walls += wall(n++, "[0.8, 0.06, 0.8]", std::string("[0, ") + side + "0.37, 0]");
    walls += wall(n++, "[0.8, 0.8, 0.06]", std::string("[0, 0, ") + side + "0.37]");
  }
  World w = build_world(parse_scene(R"({"brim": 1, "name": "t", "frames": 1, "world": {"time_step": 0.005}, "bodies": [
      {"kind": "grid_fluid", "name": "water", "cell_size": 0.03, "box": {"lo": [-0.48, -0.48, -0.48], "hi": [0.48, 0.48, 0.48]},
       "fill": [{"kind": "box", "lo": [-0.34, -0.34, -0.34], "hi": [0.34, 0.34, 0.34]}]})" +
                                    walls + "]}"));
  double fastest = 0.0;
  for (int s = 0; s < 20; ++s) {
    const StepReport r = w.step();
    ASSERT_TRUE(r.ok);
    for (const double v : w.v(0)) fastest = std::max(fastest, std::abs(v));
  }
  EXPECT_LT(fastest, 1e-6);
}

}  // namespace
}  // namespace brim::grid_fluid_scene_test
