#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "brim/core/error.h"
#include "brim/scene/scene.h"

/// Scenes with springs, rods and grains: what is accepted, and what each mistake is told.
namespace brim::spring_rod_grain_scenes_test {
namespace {

struct Case {
  const char* what;
  const char* body;                ///< inside of the braces of one entry of "bodies"
  const char* place;               ///< pointer in the message; "" when the body is good
  std::vector<const char*> words;  ///< other things that the message must say
};

/// The message that loading and building ends with; "" when all is well.
std::string message(const char* body) {
  const std::string text = std::string(R"({"brim": 1, "name": "test", "frames": 1, "bodies": [{)") + body + "}]}";
  try {
    const Scene scene = parse_scene(text, "scene.json");
    build_world(scene);
    return "";
  } catch (const InputError& e) {
    return e.what();
  }
}

const char* const kNet = R"("kind": "mass_spring", "name": "n", "grid": {"size": [1, 1], "cells": [4, 4]})";

const std::vector<Case> kCases = {
    {"Sheet", kNet, "", {}},
    {"Net",
     R"("kind": "mass_spring", "name": "n", "grid": {"size": [1, 1], "cells": [4, 4]}, "form": "net", "slack": true,
        "thickness": 0.05, "constraints": [{"select": {"kind": "corners", "which": [0, 3]}}])",
     "",
     {}},
    {"Solid",
     R"("kind": "mass_spring", "name": "n", "shape": {"kind": "box", "size": [1, 1, 1]}, "lattice_spacing": 0.3)",
     "",
     {}},
    {"NoSource", R"("kind": "mass_spring", "name": "n")", "/bodies/0", {"\"shape\"", "\"grid\""}},
    {"TwoSources",
     R"("kind": "mass_spring", "name": "n", "mesh": "a.obj", "grid": {"size": [1, 1], "cells": [4, 4]})",
     "/bodies/0/mesh",
     {"\"grid\"", "give one"}},
    {"FormOfASolid",
     R"("kind": "mass_spring", "name": "n", "shape": {"kind": "box", "size": [1, 1, 1]}, "lattice_spacing": 0.3,
        "form": "net")",
     "/bodies/0/form",
     {"solid"}},
    {"ThicknessOfASolid",
     R"("kind": "mass_spring", "name": "n", "shape": {"kind": "box", "size": [1, 1, 1]}, "lattice_spacing": 0.3,
        "thickness": 0.1)",
     "/bodies/0/thickness",
     {"solid"}},
    {"LatticeOfAGrid",
     R"("kind": "mass_spring", "name": "n", "grid": {"size": [1, 1], "cells": [4, 4]}, "lattice_spacing": 0.3)",
     "/bodies/0/lattice_spacing",
     {"shape"}},
    {"LatticeMissing",
     R"("kind": "mass_spring", "name": "n", "shape": {"kind": "box", "size": [1, 1, 1]})",
     "/bodies/0",
     {"\"lattice_spacing\" is missing"}},
    {"StiffnessZero",
     R"("kind": "mass_spring", "name": "n", "grid": {"size": [1, 1], "cells": [4, 4]}, "stiffness": 0)",
     "/bodies/0/stiffness",
     {"above 0"}},
    {"FormUnknown",
     R"("kind": "mass_spring", "name": "n", "grid": {"size": [1, 1], "cells": [4, 4]}, "form": "nett")",
     "/bodies/0/form",
     {"did you mean \"net\"?"}},
    {"CellsAbsurd",
     R"("kind": "mass_spring", "name": "n", "grid": {"size": [1, 1], "cells": [4000, 4000]})",
     "/bodies/0/grid/cells",
     {"memory_limit"}},

    {"Rod", R"("kind": "rod", "name": "r", "points": [[0, 0, 0], [1, 0, 0]], "segments": 5, "radius": 0.1)", "", {}},
    {"Ring",
     R"("kind": "rod", "name": "r", "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "segments": 9, "radius": 0.05,
        "closed": true)",
     "",
     {}},
    {"Coil",
     R"("kind": "rod", "name": "r", "helix": {"radius": 1, "pitch": 0.3, "turns": 2.5}, "segments": 60, "radius": 0.05,
        "rests_straight": true, "constraints": [{"select": {"kind": "sphere", "center": [1, 0, 0], "radius": 0.01}}])",
     "",
     {}},
    {"NoLine", R"("kind": "rod", "name": "r", "segments": 5, "radius": 0.1)", "/bodies/0", {"\"points\"", "\"helix\""}},
    {"TwoLines",
     R"("kind": "rod", "name": "r", "points": [[0, 0, 0], [1, 0, 0]], "segments": 5, "radius": 0.1,
        "helix": {"radius": 1, "pitch": 1, "turns": 1})",
     "/bodies/0/helix",
     {"give one"}},
    {"OnePoint",
     R"("kind": "rod", "name": "r", "points": [[0, 0, 0]], "segments": 5, "radius": 0.1)",
     "/bodies/0/points",
     {"at least 2"}},
    {"RingOfTwoPoints",
     R"("kind": "rod", "name": "r", "points": [[0, 0, 0], [1, 0, 0]], "segments": 5, "radius": 0.1, "closed": true)",
     "/bodies/0/points",
     {"at least 3"}},
    {"RingOfTwoSegments",
     R"("kind": "rod", "name": "r", "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "segments": 2, "radius": 0.1,
        "closed": true)",
     "/bodies/0/segments",
     {"at least 3"}},
    {"ClosedHelix",
     R"("kind": "rod", "name": "r", "helix": {"radius": 1, "pitch": 1, "turns": 1}, "segments": 5, "radius": 0.1,
        "closed": true)",
     "/bodies/0/closed",
     {"two ends"}},
    {"SamePointTwice",
     R"("kind": "rod", "name": "r", "points": [[0, 0, 0], [1, 0, 0], [1, 0, 0]], "segments": 5, "radius": 0.1)",
     "/bodies/0/points/2",
     {"differ"}},
    {"FoldedLine",
     R"("kind": "rod", "name": "r", "points": [[0, 0, 0], [1, 0, 0], [0, 0, 0]], "segments": 4, "radius": 0.1)",
     "/bodies/0",
     {"folds back"}},
    {"RadiusMissing",
     R"("kind": "rod", "name": "r", "points": [[0, 0, 0], [1, 0, 0]], "segments": 5)",
     "/bodies/0",
     {"\"radius\" is missing"}},
    {"SegmentsAbsurd",
     R"("kind": "rod", "name": "r", "points": [[0, 0, 0], [1, 0, 0]], "segments": 2000000, "radius": 0.1)",
     "/bodies/0/segments",
     {"1000000"}},

    {"Grains", R"("kind": "points", "name": "p", "radius": 0.1, "grid": {"count": [3, 3, 3], "jitter": 0.01})", "", {}},
    {"GrainsByHand",
     R"("kind": "points", "name": "p", "radius": 0.1, "radius_spread": 0.2, "positions": [[0, 0, 0], [1, 0, 0]])",
     "",
     {}},
    {"NoGrains", R"("kind": "points", "name": "p", "radius": 0.1)", "/bodies/0", {"\"grid\"", "\"positions\""}},
    {"GridAndPositions",
     R"("kind": "points", "name": "p", "radius": 0.1, "grid": {"count": [3, 3, 3]}, "positions": [[0, 0, 0]])",
     "/bodies/0/positions",
     {"give one"}},
    {"CountAbsurd",
     R"("kind": "points", "name": "p", "radius": 0.1, "grid": {"count": [10000, 10000, 10000]})",
     "/bodies/0/grid/count",
     {"memory_limit"}},
    {"SpreadTooLarge",
     R"("kind": "points", "name": "p", "radius": 0.1, "radius_spread": 0.9, "grid": {"count": [3, 3, 3]})",
     "/bodies/0/radius_spread",
     {"0.5"}},
    {"GrainRadiusZero",
     R"("kind": "points", "name": "p", "radius": 0, "grid": {"count": [3, 3, 3]})",
     "/bodies/0/radius",
     {"above 0"}},
};

TEST(SpringRodGrainScenes, GoodOnesAreAcceptedAndEveryMistakeIsToldWhereAndWhat) {
  for (const Case& c : kCases) {
    const std::string text = message(c.body);
    SCOPED_TRACE(std::string(c.what) + ": " + text);
    if (*c.place == '\0') {
      EXPECT_EQ(text, "");
      continue;
    }
    EXPECT_NE(text.find(std::string(": ") + c.place + ": "), std::string::npos) << "expected place " << c.place;
    for (const char* word : c.words) EXPECT_NE(text.find(word), std::string::npos) << "expected the words: " << word;
    EXPECT_EQ(text.find('\n'), std::string::npos) << "one line";
  }
}

TEST(SpringRodGrainScenes, ARodIsDividedEvenlyAndKeepsItsEnds) {
  const Scene scene = parse_scene(
      R"({"brim": 1, "name": "test", "frames": 1, "bodies": [{"kind": "rod", "name": "r", "radius": 0.05,
          "points": [[0, 0, 0], [2, 0, 0], [2, 1, 0]], "segments": 6, "transform": {"position": [0, 0, 1]}}]})",
      "scene.json");
  const World world = build_world(scene);
  const auto q = world.q(0);
  ASSERT_EQ(q.size(), 21u);
  EXPECT_NEAR(q[0], 0.0, 1e-15);
  EXPECT_NEAR(q[3], 0.5, 1e-15);
  EXPECT_NEAR(q[18], 2.0, 1e-15);
  EXPECT_NEAR(q[19], 1.0, 1e-15);
  EXPECT_NEAR(q[20], 1.0, 1e-15);
}

}  // namespace
}  // namespace brim::spring_rod_grain_scenes_test
