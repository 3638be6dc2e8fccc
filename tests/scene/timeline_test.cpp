#include "brim/scene/timeline.h"

#include <gtest/gtest.h>

#include "brim/core/error.h"
#include "brim/raster/shape.h"
#include "brim/scene/pairs/pair_table.h"
#include "brim/scene/scene.h"
#include "brim/world/body_motion.h"
#include "brim/world/world.h"

/// Edits at given times, and edits of bodies of every kind.
namespace brim::timeline_test {
namespace {

std::string scene_with(const std::string& timeline) {
  return R"({"brim": 1, "name": "s", "duration": 1, "world": {"voxel_size": 0.05}, "materials": {"ice": {"friction": 0}},
    "bodies": [
      {"kind": "obstacle", "name": "floor", "shape": {"kind": "plane"}},
      {"kind": "obstacle", "name": "belt", "shape": {"kind": "sphere", "radius": 0.2},
       "keyframes": [{"time": 0}, {"time": 1, "offset": [1, 0, 0]}], "transform": {"position": [5, 0, 1]}},
      {"kind": "rigid", "name": "ball", "shape": {"kind": "sphere", "radius": 0.2}, "transform": {"position": [0, 0, 2]},
       "repeat": {"count": [2, 1, 1], "spacing": [1, 1, 1]}}],
    "attachments": [{"name": "pin", "body": "ball.0", "point": [0, 0, 2]}],
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

TEST(Timeline, SaysWhatIsWrongBeforeTheRunBegins) {
  EXPECT_EQ(message(R"({"at": 1, "freeze": "bell"})"), "/timeline/0/freeze: \"bell\" is not a body");
  EXPECT_EQ(message(R"({"at": 1, "detach": "nail"})"), "/timeline/0/detach: \"nail\" is not an attachment or joint");
  EXPECT_EQ(
      message(R"({"at": 1})"),
      "/timeline/0: says nothing to do; it must have one of \"freeze\", \"thaw\", \"remove\", \"move\", "
      "\"detach\", \"gravity\", \"set_velocity\", \"set_material\", \"set_drive\", \"grab\", \"pull\", \"release\"");
  EXPECT_EQ(message(R"({"at": 1, "freeze": "ball", "remove": "ball"})"),
            "/timeline/0/remove: it is not allowed beside \"freeze\"; an entry is one edit");
  EXPECT_EQ(message(R"({"at": 1, "freeze": "ball", "offset": [0, 0, 1]})"),
            "/timeline/0/offset: it is not allowed beside \"freeze\"; it is for \"move\"");
  EXPECT_EQ(message(R"({"at": 1, "set_material": "ball"})"),
            "/timeline/0: \"set_material\" needs \"material\", the name of one");
  EXPECT_EQ(message(R"({"at": 1, "set_material": "ball", "material": "snow"})"),
            "/timeline/0/material: \"snow\" is not a material of the scene");
  EXPECT_EQ(message(R"({"at": 1, "move": "belt", "offset": [0, 0, 1]})"),
            "/timeline/0/move: \"belt\" follows keyframes; it cannot be changed by \"move\"");
  EXPECT_EQ(message(R"({"at": 1, "freeze": "b*"})"),
            "/timeline/0/freeze: \"belt\" follows keyframes; it cannot be changed by \"freeze\"");
  EXPECT_NE(message(R"({"at": -1, "remove": "ball"})").find("must be a number from 0"), std::string::npos);
}

TEST(Timeline, EntriesThatTheRunDoesNotGetToAreTold) {
  // A second of 60 steps: the last one begins at 59/60 s.
  const auto late = [](const std::string& at) {
    return late_entries(
        parse_scene(scene_with(R"({"at": 0, "freeze": "floor"}, {"at": )" + at + R"(, "thaw": "floor"})"), "s.json"));
  };
  for (const char* at : {"0", "0.5", "0.98", "0.98333333"}) {
    EXPECT_TRUE(late(at).empty()) << at;
    // Held against what happens.
    World world = build_world(parse_scene(scene_with(fmt::format(R"({{"at": {}, "remove": "ball.1"}})", at))));
    for (int s = 0; s < 60; ++s) world.step();
    EXPECT_TRUE(world.removed(3)) << at;
  }
  for (const char* at : {"0.984", "1", "7"}) {
    ASSERT_EQ(late(at).size(), 1u) << at;
    EXPECT_EQ(late(at)[0].find("s.json:9: /timeline/1/at: "), 0u) << late(at)[0];
    World world = build_world(parse_scene(scene_with(fmt::format(R"({{"at": {}, "remove": "ball.1"}})", at))));
    for (int s = 0; s < 60; ++s) world.step();
    EXPECT_FALSE(world.removed(3)) << at;
  }
}

TEST(Timeline, EditsAllThatANameMeansAtItsTime) {
  World w = build_world(parse_scene(scene_with(R"(
    {"at": 0.2, "remove": "ball.1"}, {"at": 0.4, "freeze": "ball.1"}, {"at": 0.1, "set_velocity": "ball", "velocity": [0, 0, 3]},
    {"at": 0.05, "detach": "p*"}, {"at": 0.05, "gravity": [0, 0, 0]}, {"at": 0.3, "set_material": "ball", "material": "ice"},
    {"at": 0.3, "move": "ball.0", "offset": [0, 2, 0], "rotation": {"axis": [0, 0, 1], "degrees": 90}})")));
  const int a = 2, b = 3;
  int refused = 0;
  while (w.state().time < 0.5)
    for (const Warning& warning : w.step().warnings) refused += warning.code == "edit_refused";
  EXPECT_TRUE(w.detached(0));
  EXPECT_TRUE(w.removed(b));
  EXPECT_EQ(refused, 1) << "what was removed cannot be frozen; the other ball still gets its material";
  EXPECT_NEAR(w.v(a)[2], 3.0, 1e-9);
  EXPECT_NEAR(w.q(a)[1], 2.0, 1e-9);
  EXPECT_NEAR(w.q(a)[3], std::sqrt(0.5), 0.01) << "a quarter turn, and what the pin turned it before";
  EXPECT_EQ(w.material(a).name, "ice");
}

TEST(Timeline, AimsDrivesOfJointsAndOfArticulatedBodies) {
  const auto scene = [](const std::string& timeline) {
    return parse_scene(R"({"brim": 1, "name": "t", "duration": 1, "world": {"gravity": [0, 0, 0]}, "bodies": [
      {"kind": "rigid", "name": "wheel", "shape": {"kind": "sphere", "radius": 0.2}},
      {"kind": "articulated", "name": "arm", "transform": {"position": [3, 0, 0]}, "links": [
        {"name": "elbow", "mass": 1, "shape": {"kind": "sphere", "radius": 0.2},
         "joint": {"kind": "revolute", "drive": {"stiffness": 500, "damping": 30}}}]}],
      "joints": [{"name": "motor", "body": "wheel", "kind": "revolute", "position": [0, 0, 0], "drive": {"damping": 10}},
                 {"name": "axle", "body": "arm", "kind": "ball", "position": [3, 0, 0]}],
      "timeline": [)" + timeline +
                           "]}",
                       "s.json");
  };
  World w = build_world(scene(R"({"at": 0.1, "set_drive": "arm", "joint": "elbow", "target": 0.4},
                                 {"at": 0.2, "set_drive": "motor", "target_velocity": 2})"));
  for (int s = 0; s < 60; ++s) w.step();
  EXPECT_NEAR(w.q(1)[0], 0.4, 1e-3);
  EXPECT_NEAR(w.v(0)[5], 2.0, 1e-3);
  const auto says = [&](const std::string& timeline) -> std::string {
    try {
      build_world(scene(timeline));
    } catch (const InputError& e) {
      const std::string text = e.what();
      return text.substr(text.find("/timeline"));
    }
    return "";
  };
  EXPECT_EQ(says(R"({"at": 1, "set_drive": "arm", "joint": "elbo", "target": 1})"),
            "/timeline/0/joint: \"elbo\" is not a joint of \"arm\" with a drive; did you mean \"elbow\"?");
  EXPECT_EQ(says(R"({"at": 1, "set_drive": "arm"})"), "/timeline/0: \"set_drive\" of the body \"arm\" needs \"joint\"");
  EXPECT_EQ(says(R"({"at": 1, "set_drive": "axle"})"), "/timeline/0/set_drive: \"axle\" has no drive");
  EXPECT_EQ(says(R"({"at": 1, "set_drive": "axe"})"), "/timeline/0/set_drive: \"axe\" is not a joint or a body");
  EXPECT_EQ(says(R"({"at": 1, "remove": "arm", "target": 1})"),
            "/timeline/0/target: it is not allowed beside \"remove\"; it is for \"set_drive\"");
}

/// Some kinds of the table fill boxes, which do not fall.
bool falls(const PairKind& k) { return k.name.find("grid") == std::string::npos; }

/// Calls f(kind, scene) with each kind of the table above a plane.
template <class F>
void for_kinds_on_a_plane(const PairTable& table, const F& f) {
  const PairKind* ground = nullptr;
  for (const PairKind& k : table.kinds)
    if (k.name == "plane") ground = &k;
  ASSERT_NE(ground, nullptr);
  for (const PairKind& kind : table.kinds) {
    if (&kind == ground || kind.name == "mesh") continue;
    SCOPED_TRACE(kind.name);
    f(kind, parse_scene(pair_scene_text(table, *ground, kind)));
    if (::testing::Test::HasFatalFailure()) return;
  }
}

TEST(EveryKind, IsFrozenMovedRemovedAndResumed) {
  PairTable table = standard_pairs();
  table.drop.speed = 0.5;
  for_kinds_on_a_plane(table, [](const PairKind& kind, const Scene& scene) {
    World w = build_world(scene), resumed = build_world(scene);
    const auto upper = [&] { return std::vector<double>(w.q(1).begin(), w.q(1).end()); };
    for (int s = 0; s < 3; ++s) ASSERT_TRUE(w.step().ok);
    w.freeze(1);
    const auto held = upper();
    for (int s = 0; s < 4; ++s) {
      const StepReport r = w.step();
      ASSERT_TRUE(r.ok);
      ASSERT_EQ(r.max_speed, 0.0);
    }
    EXPECT_EQ(upper(), held);
    resumed.set_state(w.state());
    EXPECT_TRUE(resumed.frozen(1));
    for (World* world : {&w, &resumed}) world->freeze(1, false), world->set_gravity(Vec3(0, 0, -9.81));
    const Vec3 before = middle_of(w.body(1));
    const double lower = w.body(1).potential_energy(w.options().environment);
    for (World* world : {&w, &resumed}) world->move(1, {Mat3::Identity(), Vec3(0.01, 0.02, 0.3)});
    // The vertices of a surface that changes are others where a node lies on it but for rounding.
    if (falls(kind)) {
      EXPECT_LT((middle_of(w.body(1)) - before - Vec3(0.01, 0.02, 0.3)).norm(), 1e-6);
    }
    const double work = w.body(1).mass() * 9.81 * 0.3;
    EXPECT_NEAR(w.body(1).potential_energy(w.options().environment) - lower, work, 1e-6 * work);
    const double before_fall = w.body(1).potential_energy(w.options().environment);
    for (int s = 0; s < 4; ++s) {
      ASSERT_TRUE(w.step().ok);
      resumed.step();
      ASSERT_EQ(w.hash(), resumed.hash());
    }
    if (falls(kind)) {
      EXPECT_LT(w.body(1).potential_energy(w.options().environment), before_fall) << "it falls";
    }
    const auto last = upper();
    w.remove(1);
    resumed.set_state(w.state());
    EXPECT_TRUE(resumed.removed(1));
    for (int s = 0; s < 3; ++s) {
      const StepReport r = w.step();
      ASSERT_TRUE(r.ok);
      EXPECT_EQ(r.contacts, 0);
      resumed.step();
      ASSERT_EQ(w.hash(), resumed.hash());
    }
    EXPECT_EQ(upper(), last);
  });
}

TEST(EveryKind, GoesOnFromAnyStateOfASpinningFallAsIfNothingHadBeen) {
  PairTable table = standard_pairs();
  for_kinds_on_a_plane(table, [](const PairKind&, const Scene& scene) {
    World w = build_world(scene), resumed = build_world(scene);
    State start = w.state();
    const std::size_t first = w.v(0).size();
    w.body(1).rigid_motion(Vec3(0, 0, -0.5), Vec3(3, 1, -2), std::span(start.v).subspan(first, w.v(1).size()));
    w.set_state(start);
    int contacts = 0;
    for (int s = 0; s < 24; ++s) {
      const State before = w.state();
      contacts += w.step().contacts;
      resumed.set_state(start), resumed.set_state(before);
      resumed.step();
      ASSERT_EQ(w.hash(), resumed.hash()) << "step " << s;
    }
    EXPECT_GT(contacts, 0) << "it must land, or the test is half blind";
  });
}

}  // namespace
}  // namespace brim::timeline_test
