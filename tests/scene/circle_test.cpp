#include "brim/scene/circle.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <numeric>
#include <random>

#include "brim/core/error.h"
#include "brim/scene/pairs/pair_table.h"
#include "brim/scene/scene.h"

/// Copies in a circle: "around" of "repeat".
namespace brim::circle_test {
namespace {

/// A scene of one body with the given keys besides its shape.
std::string scene_with(const std::string& keys, const std::string& kind = "rigid") {
  return R"({"brim": 1, "name": "c", "frames": 4, "world": {"gravity": [0, 0, 0], "time_step": 0.25}, "bodies": [
    {"kind": ")" +
         kind + R"(", "name": "b", "shape": {"kind": "box", "size": [0.3, 0.2, 0.1]}, )" + keys + "}]}";
}

World world_of(const std::string& keys, const std::string& kind = "rigid") {
  return build_world(parse_scene(scene_with(keys, kind), "c.json"));
}

std::string message(const std::string& keys) {
  try {
    world_of(keys);
    return "";
  } catch (const InputError& e) {
    return e.what();
  }
}

Vec3 place(const World& w, int b) { return {w.q(b)[0], w.q(b)[1], w.q(b)[2]}; }
Vec3 velocity(const World& w, int b) { return {w.v(b)[0], w.v(b)[1], w.v(b)[2]}; }
Vec3 spin(const World& w, int b) { return {w.v(b)[3], w.v(b)[4], w.v(b)[5]}; }
Quat rotation(const World& w, int b) { return Quat(w.q(b)[3], w.q(b)[4], w.q(b)[5], w.q(b)[6]); }

/// Where a body's vertices are shown, [m].
std::vector<Vec3> shown(const Body& body) {
  std::vector<Vec3f> x(body.display().vertices);
  body.display_positions(x);
  std::vector<Vec3> out;
  for (const Vec3f& p : x) out.push_back(p.cast<double>());
  return out;
}

TEST(Circle, FourCopiesStandAQuarterOfATurnApartAndTurnWithTheirPlaces) {
  const World w =
      world_of(R"("transform": {"position": [2, 0, 0.5]}, "velocity": [0, 1, 3], "angular_velocity": [4, 0, 0],
    "repeat": {"around": {"point": [1, 0, 7], "count": 4}})");
  ASSERT_EQ(w.body_count(), 4);
  const Vec3 places[] = {{2, 0, 0.5}, {1, 1, 0.5}, {0, 0, 0.5}, {1, -1, 0.5}};
  const Vec3 ways[] = {{0, 1, 3}, {-1, 0, 3}, {0, -1, 3}, {1, 0, 3}};
  for (int b = 0; b < 4; ++b) {
    EXPECT_EQ(w.body(b).name(), fmt::format("b.{}", b));
    EXPECT_LT((place(w, b) - places[b]).norm(), 1e-12) << b;
    EXPECT_LT((velocity(w, b) - ways[b]).norm(), 1e-12) << b;
    EXPECT_LT((spin(w, b) - 4.0 * (places[b] - Vec3(1, 0, 0.5))).norm(), 1e-12) << b;
    EXPECT_LT(rotation(w, b).angularDistance(Quat(Eigen::AngleAxisd(b * std::numbers::pi / 2, Vec3::UnitZ()))), 1e-7);
  }
}

TEST(Circle, ACopyIsTheFirstTurnedAboutTheAxis) {
  for (unsigned seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(-2.0, 2.0);
    const auto vec = [&] { return Vec3(any(random), any(random), any(random)); };
    Placement first;
    first.position = vec();
    first.rotation = Quat(any(random), any(random), any(random), any(random)).normalized();
    first.scale = 0.7;
    first.velocity = vec();
    first.angular_velocity = vec();
    const Circle circle{vec(), vec().normalized(), 5, 100.0 * any(random)};
    for (int k = 0; k < circle.count; ++k) {
      // By a matrix, not a quaternion: Rodrigues' formula.
      const double a = k * circle.degrees * std::numbers::pi / 180.0;
      Mat3 cross;
      for (int c = 0; c < 3; ++c) cross.col(c) = circle.axis.cross(Vec3(Vec3::Unit(c)));
      const Mat3 turn = Mat3::Identity() + std::sin(a) * cross + (1.0 - std::cos(a)) * cross * cross;
      const Placement p = circle.place(first, k);
      const Vec3 x = vec();
      EXPECT_LT((p.apply(x) - (circle.point + turn * (first.apply(x) - circle.point))).norm(), 1e-13);
      EXPECT_LT((p.velocity - turn * first.velocity).norm(), 1e-13);
      EXPECT_LT((p.angular_velocity - turn * first.angular_velocity).norm(), 1e-13);
    }
  }
}

TEST(Circle, AGridIsCopiedWholeAndEveryCopyHasChancesOfItsOwn) {
  const char* const grid = R"("count": [1, 1, 2], "spacing": [0, 0, 1])";
  const auto ring = [&](const std::string& more) {
    return world_of(R"("transform": {"position": [2, 0, 0]}, "repeat": {)" + std::string(grid) + more +
                    R"(, "around": {"count": 3, "degrees": -90}})");
  };
  const World w = ring("");
  ASSERT_EQ(w.body_count(), 6);
  const Vec3 places[] = {{2, 0, 0}, {2, 0, 1}, {0, -2, 0}, {0, -2, 1}, {-2, 0, 0}, {-2, 0, 1}};
  for (int b = 0; b < 6; ++b) EXPECT_LT((place(w, b) - places[b]).norm(), 1e-12) << b;

  const World shaken = ring(R"(, "jitter": [0.1, 0, 0])");
  for (int b = 0; b < 6; ++b) {
    const Vec3 off = place(shaken, b) - places[b], outwards = Vec3(places[b].x(), places[b].y(), 0).normalized();
    EXPECT_LT((off - off.dot(outwards) * outwards).norm(), 1e-12) << "an offset along x is one along the radius";
    for (int c = 0; c < b; ++c)
      EXPECT_GT(std::abs(off.norm() - (place(shaken, c) - places[c]).norm()), 1e-6) << b << " and " << c;
  }
}

TEST(Circle, TheFirstCopyIsTheBodyBitForBit) {
  const std::string keys =
      R"("transform": {"position": [0.1, 0.7, 0.3], "rotation": {"euler_degrees": [10, 20, 30]}}, "velocity": [0.3, 0.1, 0.7])";
  const World alone = world_of(keys),
              ring = world_of(keys + R"(, "repeat": {"around": {"axis": [1, 2, 3], "count": 7}})");
  EXPECT_TRUE(std::ranges::equal(alone.q(0), ring.q(0)));
  EXPECT_TRUE(std::ranges::equal(alone.v(0), ring.v(0)));
}

TEST(Circle, KeyframesTurnWithTheirCopies) {
  World w = world_of(R"("transform": {"position": [1, 0, 0]}, "repeat": {"around": {"count": 4}},
    "keyframes": [{"time": 0}, {"time": 1, "offset": [-0.5, 0, 0.2], "rotation": {"axis": [1, 0, 0], "degrees": 60}}])",
                     "obstacle");
  for (int s = 0; s < 4; ++s) w.step();
  const Quat tipped(Eigen::AngleAxisd(std::numbers::pi / 3, Vec3::UnitX()));
  for (int b = 0; b < 4; ++b) {
    const Quat turn(Eigen::AngleAxisd(b * std::numbers::pi / 2, Vec3::UnitZ()));
    EXPECT_LT((place(w, b) - turn * Vec3(0.5, 0, 0.2)).norm(), 1e-9) << b;
    EXPECT_LT(rotation(w, b).angularDistance(turn * tipped), 1e-7) << b;
  }
}

TEST(Circle, GivenMotionsOfNodesTurnWithTheirCopies) {
  World w =
      world_of(R"("lattice_spacing": 0.1, "transform": {"position": [1, 0, 0]}, "repeat": {"around": {"count": 2}},
    "constraints": [{"select": {"kind": "all"}, "velocity": [1, 0, 0.5]}])",
               "finite_elements");
  const auto middle = [&](int b) {
    const std::vector<Vec3> x = shown(w.body(b));
    return Vec3(std::accumulate(x.begin(), x.end(), Vec3(Vec3::Zero())) / static_cast<double>(x.size()));
  };
  for (int s = 0; s < 4; ++s) w.step();
  EXPECT_LT((middle(0) - Vec3(2, 0, 0.5)).norm(), 1e-5);
  EXPECT_LT((middle(1) - Vec3(-2, 0, 0.5)).norm(), 1e-5);
}

TEST(Circle, EveryKindHasCopiesInACircleExceptFluidsOnGrids) {
  PairTable table = standard_pairs();
  std::size_t made = 0;
  for (const PairKind& kind : table.kinds) {
    if (kind.name == "plane") continue;
    SCOPED_TRACE(kind.name);
    Json scene = Json::parse(pair_scene_text(table, table.find("plane"), kind));
    Json body = scene["bodies"][1];
    if (kind.name != "grid_fluid") body.erase("constraints");
    body["repeat"] = {{"around", {{"count", 3}, {"axis", {1, 2, 2}}, {"point", {0, 5, 0}}}}};
    scene["bodies"] = {body};
    if (kind.name == "grid_fluid") {
      EXPECT_THROW(build_world(parse_scene(scene.dump())), InputError);
      continue;
    }
    const World w = build_world(parse_scene(scene.dump()));
    ASSERT_EQ(w.body_count(), 3);
    const std::vector<Vec3> first = shown(w.body(0));
    for (int b = 1; b < 3; ++b) {
      const Quat turn(Eigen::AngleAxisd(b * 2.0 * std::numbers::pi / 3.0, Vec3(1, 2, 2).normalized()));
      const std::vector<Vec3> copy = shown(w.body(b));
      ASSERT_EQ(copy.size(), first.size());
      double worst = 0.0;
      for (std::size_t i = 0; i < first.size(); ++i)
        worst = std::max(worst, (copy[i] - Vec3(0, 5, 0) - turn * (first[i] - Vec3(0, 5, 0))).norm());
      EXPECT_LT(worst, 1e-5) << "[m], positions of about 10 m in single precision";
      const Vec3 momentum = w.body(0).linear_momentum(w.v(0));
      EXPECT_LT((w.body(b).linear_momentum(w.v(b)) - turn * momentum).norm(), 1e-9 * (1.0 + momentum.norm()));
    }
    ++made;
  }
  EXPECT_GE(made, 12u);
}

TEST(Circle, MistakesAreToldWithWhatIsAllowed) {
  const auto said = [](const std::string& repeat) { return message(R"("repeat": {)" + repeat + "}"); };
  const struct {
    const char* repeat;
    std::vector<std::string> words;
  } bad[] = {{R"("spacing": [1, 1, 1])", {"/bodies/0/repeat", "neither \"count\" nor \"around\"", "in a circle"}},
             {R"("around": {})", {"/bodies/0/repeat/around", "\"count\" is missing", "whole number"}},
             {R"("around": {"count": 0})", {"/around/count", "from 1 to 1000"}},
             {R"("around": {"count": [1, 1, 5]})", {"/around/count", "a list of 3", "whole number"}},
             {R"("around": 5)", {"/around", "an object with \"count\""}},
             {R"("around": {"count": 4, "axis": [0, 0, 0]})", {"/around/axis", "direction of some length"}},
             {R"("around": {"count": 4, "angle": 30})", {"/around/angle", "did you mean \"degrees\""}},
             {R"("around": {"count": 4, "center": [0, 0, 1]})", {"/around/center", "did you mean \"point\""}},
             {R"("circle": {"count": 4})", {"/repeat/circle", "did you mean \"around\""}},
             {R"("around": {"count": 12, "degrees": 360})", {"/around/degrees", "copy 1 on copy 0", "30 degrees"}},
             {R"("around": {"count": 5, "degrees": -90})", {"/around/degrees", "copy 4 on copy 0", "72 degrees"}},
             {R"("around": {"count": 2, "degrees": 0})", {"/around/degrees", "copy 1 on copy 0"}}};
  for (const auto& b : bad)
    for (const std::string& word : b.words)
      EXPECT_NE(said(b.repeat).find(word), std::string::npos) << b.repeat << ": " << said(b.repeat);
  EXPECT_EQ(said(R"("around": {"count": 4, "degrees": 90})"), "");
  EXPECT_EQ(said(R"("around": {"count": 1, "degrees": 360})"), "");
}

}  // namespace
}  // namespace brim::circle_test
