#include <fmt/format.h>
#include <gtest/gtest.h>

#include <numbers>

#include "brim/scene/scene.h"

/// Keyframes of obstacles.
namespace brim::motion_test {
namespace {

/// Rotation of an obstacle with these keyframes after each of eight steps of a quarter of a second.
std::vector<Quat> turned(const std::string& keys) {
  World w =
      build_world(parse_scene(fmt::format(R"({{"brim": 1, "name": "k", "frames": 8, "world": {{"time_step": 0.25}},
                      "bodies": [{{"kind": "obstacle", "name": "o", "shape": {{"kind": "sphere", "radius": 0.1}}, "keyframes": {}}}]}})",
                                          keys),
                              "keys"));
  std::vector<Quat> out;
  for (int i = 0; i < 8; ++i) {
    w.step();
    out.emplace_back(w.q(0)[3], w.q(0)[4], w.q(0)[5], w.q(0)[6]);
  }
  return out;
}

Quat about(const Vec3& axis, double degrees) {
  return Quat(Eigen::AngleAxisd(degrees * std::numbers::pi / 180.0, axis.normalized()));
}

void expect_turns(const std::string& keys, const std::vector<Quat>& expected) {
  const std::vector<Quat> found = turned(keys);
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_LT(found[i].angularDistance(expected[i]), 1e-7) << keys << ", step " << i;
}

/// `degrees` after each step.
std::vector<Quat> all_about(const Vec3& axis, std::initializer_list<double> degrees) {
  std::vector<Quat> out;
  for (const double d : degrees) out.push_back(about(axis, d));
  return out;
}

TEST(Motion, OfManyTurnsAboutAnAxisIsLinearInTheAngle) {
  const Vec3 z = Vec3::UnitZ();
  const auto two = all_about(z, {90, 180, 270, 360, 450, 540, 630, 720});
  expect_turns(R"([{"time": 0}, {"time": 2, "rotation": {"axis": [0, 0, 2], "degrees": 720}}])", two);
  expect_turns(R"([{"time": 0}, {"time": 2, "rotation": {"axis": [0, 0, -1], "degrees": -720}}])", two);
  expect_turns(R"([{"time": 0}, {"time": 2, "rotation": {"euler_degrees": [0, 0, 720]}}])", two);
  expect_turns(R"([{"time": 0}, {"time": 1, "rotation": {"axis": [0, 0, 1], "degrees": 270}},
                   {"time": 2, "rotation": {"axis": [0, 0, 1], "degrees": 540}}])",
               all_about(z, {67.5, 135, 202.5, 270, 337.5, 405, 472.5, 540}));
  expect_turns(R"([{"time": 0, "rotation": {"axis": [1, 1, 0], "degrees": -200}}, {"time": 2}])",
               all_about(Vec3(1, 1, 0), {-175, -150, -125, -100, -75, -50, -25, 0}));
}

TEST(Motion, BetweenOtherRotationsTakesTheShortWay) {
  expect_turns(R"([{"time": 0}, {"time": 2, "rotation": {"quaternion": [0, 0, 0, -1]}}])",
               all_about(Vec3(0, 0, -1), {22.5, 45, 67.5, 90, 112.5, 135, 157.5, 180}));
  const std::vector<Quat> found = turned(R"([{"time": 0, "rotation": {"axis": [1, 0, 0], "degrees": 90}},
                                             {"time": 2, "rotation": {"axis": [0, 1, 0], "degrees": 90}}])");
  EXPECT_LT(found[3].angularDistance(about(Vec3::UnitX(), 90).slerp(0.5, about(Vec3::UnitY(), 90))), 1e-7);
}

TEST(Motion, KeepsItsOffsetsWhereKeysAreAdded) {
  World w = build_world(parse_scene(R"({"brim": 1, "name": "k", "frames": 8, "world": {"time_step": 0.25}, "bodies": [
      {"kind": "obstacle", "name": "o", "shape": {"kind": "sphere", "radius": 0.1}, "keyframes": [
        {"time": 0}, {"time": 2, "offset": [2, 0, 4], "rotation": {"axis": [0, 0, 1], "degrees": 1000}}]}]})",
                                    "offsets"));
  for (int i = 1; i <= 8; ++i) {
    w.step();
    EXPECT_LT((Vec3(w.q(0)[0], w.q(0)[1], w.q(0)[2]) - 0.125 * i * Vec3(2, 0, 4)).norm(), 1e-12) << i;
  }
}

}  // namespace
}  // namespace brim::motion_test
