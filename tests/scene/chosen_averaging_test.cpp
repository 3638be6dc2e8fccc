#include "brim/scene/chosen_averaging.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "brim/scene/scene.h"

namespace brim::chosen_averaging_test {
namespace {

TEST(ChosenAveraging, TheThicknessOfBoxesBallsAndRingsIsThatOfTheirShape) {
  const SolidSize plate{6.0 * 4.0 * 0.5, 2.0 * (24.0 + 3.0 + 2.0), Vec3(4, 0.5, 6), 1.0};
  EXPECT_NEAR(plate.thickness(), 0.5, 1e-12);
  const SolidSize bar{1.0 * 0.2 * 0.2, 4.0 * 0.2 + 2.0 * 0.04, Vec3(1, 0.2, 0.2), 1.0};
  EXPECT_NEAR(bar.thickness(), 0.2, 1e-12);
  const SolidSize ball{M_PI / 6.0, M_PI, Vec3::Ones(), 1.0};
  EXPECT_NEAR(ball.thickness(), 1.0, 1e-12);
  const double r = 1.0, R = 2.5;
  const SolidSize ring{2.0 * M_PI * M_PI * R * r * r, 4.0 * M_PI * M_PI * R * r,
                       Vec3(2.0 * (R + r), 2.0 * (R + r), 2.0 * r), 1.0};
  EXPECT_NEAR(ring.thickness(), 2.0 * r, 1e-12);
  const double t = 0.05;  // shell of a ball: at most twice its thickness
  const SolidSize shell{M_PI * t, 2.0 * M_PI, Vec3::Ones(), 1.0};
  EXPECT_GE(shell.thickness(), t);
  EXPECT_LE(shell.thickness(), 2.0 * t + 1e-12);
}

/// Energy of a solid bent into a parabola, over that with a given share or none.
struct Bent {
  double given, none;
};
Bent bent(const std::string& body, double share) {
  const auto energy = [&](const std::string& averaging) {
    World w = build_world(parse_scene(fmt::format(R"({{"brim": 1, "name": "bent", "duration": 1, "bodies": [{{
        "name": "body", "poisson_ratio": 0, {}{}}}]}})",
                                                  body, averaging),
                                      "scene.json"));
    State state = w.state();
    for (std::size_t i = 0; i + 2 < state.q.size(); i += 3) state.q[i + 2] += 0.01 * state.q[i] * state.q[i];
    w.set_state(std::move(state));
    return w.body(0).potential_energy({});
  };
  const double chosen = energy("");
  return {chosen / energy(fmt::format(R"(, "averaging": {})", share)), chosen / energy(R"(, "averaging": 0)")};
}

TEST(ChosenAveraging, BarsAndPlatesOfFewCellsAreAveragedAndNothingElse) {
  const char* kind = R"("kind": "finite_elements", "shape": {"kind": "box", "size": )";
  for (const char* slender : {R"([1, 0.2, 0.2]}, "lattice_spacing": 0.1)", R"([1, 0.2, 0.2]}, "lattice_spacing": 0.05)",
                              R"([0.8, 0.6, 0.1]}, "lattice_spacing": 0.05)"}) {
    const Bent b = bent(std::string(kind) + slender, 0.8);
    EXPECT_NEAR(b.given, 1.0, 1e-12) << slender;
    EXPECT_LT(b.none, 1.0 - 1e-5) << slender;
  }
  for (const char* other : {R"([1, 0.2, 0.2]}, "lattice_spacing": 0.04)", R"([0.6, 0.2, 0.2]}, "lattice_spacing": 0.1)",
                            R"([0.4, 0.4, 0.4]}, "lattice_spacing": 0.2)"}) {
    const Bent b = bent(std::string(kind) + other, 0.8);
    EXPECT_NEAR(b.none, 1.0, 1e-12) << other;
    EXPECT_GT(b.given, 1.0 + 1e-5) << other;
  }
}

TEST(ChosenAveraging, SoftImagesOfThreeSpacingsAreAveragedThoseOfFourAreNot) {
  const char* kind =
      R"("kind": "image_volume", "motion": "deformable", "image_spacing": 0.025, "shape": {"kind": "box", "size": [1, 0.2, 0.2]}, "lattice_spacing": )";
  EXPECT_NEAR(bent(std::string(kind) + "0.075", 0.9).given, 1.0, 1e-12);
  EXPECT_NEAR(bent(std::string(kind) + "0.05", 0.9).none, 1.0, 1e-12);
}

}  // namespace
}  // namespace brim::chosen_averaging_test
