#include <gtest/gtest.h>

#include "brim/core/error.h"
#include "brim/scene/document.h"
#include "brim/scene/pairs/pair_table.h"
#include "brim/scene/scene.h"
#include "brim/world/body_motion.h"
#include "brim/world/world.h"

/// Hands on bodies of every kind, and in the timeline of a scene.
namespace brim::grab_kinds_test {
namespace {

TEST(GrabScenes, EveryKindIsPulledExceptFluidsOnGridsAndWhatIsFixed) {
  PairTable table = standard_pairs();
  std::size_t pulled = 0, refused = 0;
  for (const PairKind& upper : table.kinds) {
    Json scene = Json::parse(pair_scene_text(table, table.find("plane"), upper));
    scene["world"]["gravity"] = {0, 0, 0};
    scene["bodies"][1].erase("velocity");
    scene["bodies"][0]["transform"] = {{"position", {0, 0, -5}}};
    World w = build_world(parse_scene(scene.dump()));
    const Vec3 at(0.013, 0.021, 0.03 - upper.lowest);
    const bool fluid = upper.name == "grid_fluid";
    try {
      w.grab(1, at);
      EXPECT_FALSE(fluid || w.body(1).immobile()) << upper.name;
    } catch (const InputError& e) {
      EXPECT_TRUE(fluid || w.body(1).immobile()) << upper.name << ": " << e.what();
      ++refused;
      continue;
    }
    const Vec3 before = *center_of_mass(w.body(1));
    const Vec3 way(0.3, 0, 0.4);
    w.pull(at + way);
    for (int s = 0; s < 40; ++s) ASSERT_TRUE(w.step().ok) << upper.name;
    // It comes along, by about as much; what hangs together loosely or is held elsewhere by less.
    const Vec3 moved = *center_of_mass(w.body(1)) - before;
    EXPECT_GT(moved.dot(way.normalized()), 0.05 * way.norm()) << upper.name;
    EXPECT_LT(moved.norm(), 2.0 * way.norm()) << upper.name;
    w.release();
    ASSERT_TRUE(w.step().ok) << upper.name;
    ++pulled;
  }
  EXPECT_EQ(pulled + refused, table.kinds.size());
  EXPECT_GE(pulled, 11u);
}

std::string scene_with(const std::string& timeline) {
  return R"({"brim": 1, "name": "s", "duration": 1, "world": {"voxel_size": 0.05},
    "bodies": [{"kind": "obstacle", "name": "floor", "shape": {"kind": "plane"}},
      {"kind": "rigid", "name": "ball", "shape": {"kind": "sphere", "radius": 0.2},
       "transform": {"position": [0, 0, 0.5]}, "repeat": {"count": [2, 1, 1], "spacing": [1, 1, 1]}}],
    "timeline": [)" +
         timeline + "]}";
}

std::string message(const std::string& timeline) {
  try {
    build_world(parse_scene(scene_with(timeline), "s.json"));
    return "";
  } catch (const InputError& e) {
    const std::string text = e.what();
    return text.substr(text.find("/timeline"));
  }
}

TEST(GrabScenes, ATimelineDoesWhatAHandDidBitForBit) {
  World by_hand = build_world(parse_scene(scene_with("")));
  World by_time = build_world(parse_scene(scene_with(R"(
    {"at": 0.25, "grab": "ball.1", "point": [1, 0, 0.3]}, {"at": 0.25, "pull": [1, 0, 0.8]},
    {"at": 0.5, "pull": [0.5, 0.2, 0.8]}, {"at": 0.75, "release": true})")));
  const double dt = by_hand.options().time_step;
  double nearest = 1.0;  // [m] to where it was pulled
  for (int s = 0; s < 60; ++s) {
    const auto now = [&](double t) { return std::abs(by_hand.state().time - t) < 0.5 * dt; };
    if (now(0.25)) by_hand.grab(2, Vec3(1, 0, 0.3)), by_hand.pull(Vec3(1, 0, 0.8));
    if (now(0.5)) by_hand.pull(Vec3(0.5, 0.2, 0.8));
    if (now(0.75)) by_hand.release();
    const StepReport a = by_hand.step(), b = by_time.step();
    ASSERT_TRUE(a.ok && b.ok && a.warnings.empty() && b.warnings.empty());
    ASSERT_EQ(by_hand.hash(), by_time.hash()) << "step " << s;
    nearest = std::min(nearest, (*center_of_mass(by_time.body(2)) - Vec3(0.5, 0.2, 0.8)).norm());
  }
  EXPECT_LT(nearest, 0.45) << "it came along from 0.62 m, turning about where it is held";
}

TEST(GrabScenes, ATimelineSaysWhatCannotBeBeforeTheRunBegins) {
  EXPECT_EQ(message(R"({"at": 1, "grab": "ball.0"})"), "/timeline/0: \"grab\" needs \"point\", where it takes hold");
  EXPECT_EQ(message(R"({"at": 1, "grab": "ball", "point": [0, 0, 1]})"),
            "/timeline/0/grab: \"ball\" means 2 bodies; one can be grabbed");
  EXPECT_EQ(message(R"({"at": 1, "grab": "floor", "point": [0, 0, 0]})"),
            "/timeline/0/grab: \"floor\" does not move; it cannot be grabbed");
  EXPECT_EQ(message(R"({"at": 1, "release": false})"), "/timeline/0/release: must be true: what is held is let go");
  EXPECT_EQ(message(R"({"at": 1, "release": true, "point": [0, 0, 1]})"),
            "/timeline/0/point: it is not allowed beside \"release\"; it is for \"grab\"");
  World w = build_world(parse_scene(scene_with(R"({"at": 0, "pull": [0, 0, 1]})")));
  const StepReport r = w.step();
  ASSERT_EQ(r.warnings.size(), 1u);
  EXPECT_EQ(r.warnings[0].code, "edit_refused");
  EXPECT_EQ(r.warnings[0].message, "pull: nothing is grabbed");
}

}  // namespace
}  // namespace brim::grab_kinds_test
