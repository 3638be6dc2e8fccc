#include <gtest/gtest.h>

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

}  // namespace
}  // namespace brim::grid_fluid_scene_test
