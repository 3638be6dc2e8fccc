#include "brim/scene/links.h"

#include <gtest/gtest.h>

#include "brim/core/error.h"
#include "brim/scene/pairs/pair_table.h"
#include "brim/scene/scene.h"
#include "brim/world/world.h"

/// Attachments and forces on bodies of every kind, and what scenes say of them.
namespace brim::links_test {
namespace {

/// Matter that moves through cells has no points.
bool has_no_points(const PairKind& k) { return k.name == "grid_fluid"; }
/// The table's contacts are softer than its bodies, which it says; nothing else may be wrong.
void expect_no_warnings(const StepReport& r, const std::string& what) {
  for (const Warning& w : r.warnings)
    if (w.code != "soft_contact") ADD_FAILURE() << what << ": " << w.message;
}

bool fixed(const PairKind& k) { return k.name == "plane" || k.name == "mesh"; }

std::string message(const std::string& text) {
  try {
    build_world(parse_scene(text));
    return "";
  } catch (const InputError& e) {
    return e.what();
  }
}

TEST(LinkScenes, EveryKindHoldsToEveryOtherKindWithoutLosingMomentum) {
  PairTable table = standard_pairs();
  table.drop.speed = 0.5;
  for (const PairKind& lower : table.kinds)
    for (const PairKind& upper : table.kinds) {
      if (has_no_points(lower) || has_no_points(upper) || fixed(upper)) continue;
      Json scene = Json::parse(pair_scene_text(table, lower, upper));
      const double touch = lower.highest + 0.5 * table.drop.gap;
      const double at = upper.name == "rod" || upper.name == "points" ? 0.03 : 0.0;
      scene["attachments"] = {{{"name", "link"},
                               {"body", "upper"},
                               {"to", "lower"},
                               {"point", {0.013 + at, 0.021, touch}},
                               {"stiffness", 300},
                               {"touch", false}}};
      const std::string what = upper.name + " on " + lower.name;
      try {
        World w = build_world(parse_scene(scene.dump()));
        const Vec3 before = w.body(0).linear_momentum(w.v(0)) + w.body(1).linear_momentum(w.v(1));
        double scale = before.norm();
        for (int s = 0; s < 12; ++s) {
          const StepReport r = w.step();
          ASSERT_TRUE(r.ok) << what;
          ASSERT_EQ(r.links.size(), 1u) << what;
          // What the maps of each kind can do, as contact has it.
          EXPECT_LT(r.momentum_error, std::max({1e-12, upper.linear, lower.linear})) << what;
          // Maps that say how much torque they lose are held to linear momentum alone.
          if (!(upper.lever + lower.lever > 0.0) && upper.name != "soft_image") {
            EXPECT_LT(r.angular_error, 1e-9) << what;
          }
          EXPECT_TRUE(std::isfinite(r.links[0].error)) << what;
          EXPECT_LT(r.links[0].error, 0.1) << what;
          expect_no_warnings(r, what);
        }
        EXPECT_GT(w.step().links[0].force.norm(), 0.0) << what;
        if (fixed(lower)) continue;
        const Vec3 after = w.body(0).linear_momentum(w.v(0)) + w.body(1).linear_momentum(w.v(1));
        // What the solve leaves; a fluid's own products are in single precision.
        const bool of_particles = upper.name == "particle_fluid" || lower.name == "particle_fluid";
        EXPECT_LT((after - before).norm(), (of_particles ? 1e-8 : 1e-9) * scale) << what;
      } catch (const InputError& e) {
        ADD_FAILURE() << what << ": " << e.what();
      }
    }
}

TEST(LinkScenes, EveryKindHangsRigidlyFromSpace) {
  PairTable table = standard_pairs();
  for (const PairKind& upper : table.kinds) {
    if (has_no_points(upper) || fixed(upper)) continue;
    Json scene = Json::parse(pair_scene_text(table, table.find("plane"), upper));
    scene["world"]["gravity"] = {0, 0, -9.81};
    scene["bodies"][1].erase("velocity");
    scene["bodies"][0]["transform"] = {{"position", {0, 0, -5}}};
    scene["attachments"] = {{{"name", "pin"}, {"body", "upper"}, {"point", {0.013, 0.021, 0.03 - upper.lowest}}}};
    World w = build_world(parse_scene(scene.dump()));
    Vec3 force = Vec3::Zero();
    double worst = 0.0;
    for (int s = 0; s < 60; ++s) {
      const StepReport r = w.step();
      ASSERT_TRUE(r.ok) << upper.name;
      expect_no_warnings(r, upper.name);
      worst = std::max(worst, r.links[0].error);
      force = r.links[0].force;
    }
    // The links of the chain swing: what a turn leaves in a step is of second order.
    EXPECT_LT(worst, upper.name == "articulated" ? 3e-4 : 1e-5) << upper.name;
    EXPECT_GT(force.z(), 0.0) << upper.name;
  }
}

TEST(LinkScenes, EveryKindFallsThroughAPartThatItDoesNotTouchAndLiesOnTheRest) {
  PairTable table = standard_pairs();
  for (const PairKind& upper : table.kinds) {
    if (fixed(upper)) continue;
    for (const bool beneath : {true, false}) {
      Json scene = Json::parse(pair_scene_text(table, table.find("plane"), upper));
      // The part of the plane that lies beneath the body, or one that is far off.
      scene["filters"] = {{{"between", {"lower", "upper"}},
                           {"region", {{"kind", "sphere"}, {"center", {beneath ? 0.0 : 60.0, 0, 0}}, {"radius", 30}}}}};
      World w = build_world(parse_scene(scene.dump()));
      std::int64_t contacts = 0;
      for (int s = 0; s < 12; ++s) {
        const StepReport r = w.step();
        ASSERT_TRUE(r.ok) << upper.name;
        contacts += r.contacts;
      }
      EXPECT_EQ(contacts > 0, !beneath) << upper.name;
    }
  }
}

TEST(LinkScenes, ARegionOfAFilterNeedsABodyThatCarriesIt) {
  PairTable table = standard_pairs();
  Json scene = Json::parse(pair_scene_text(table, table.find("plane"), table.find("grid_fluid")));
  scene["filters"] = {{{"between", {"lower", "upper"}}, {"to_region", {{"kind", "all"}}}}};
  EXPECT_NE(message(scene.dump()).find("carries no region along"), std::string::npos) << message(scene.dump());
}

TEST(LinkScenes, AListOfAWrongLengthIsSaidWithItsPlace) {
  for (const char* wiring : {R"("forces": [{"name": "w", "wind": {"velocity": [0, 0]}}])",
                             R"("joints": [{"name": "j", "body": "b", "kind": "ball", "position": [0, 0]}])"}) {
    const std::string said = message(R"({"brim": 1, "name": "x", "frames": 1, "bodies": [
      {"kind": "rigid", "name": "b", "shape": {"kind": "sphere", "radius": 1}}], )" +
                                     std::string(wiring) + "}");
    EXPECT_NE(said.find("a list of 2 is not allowed; must have exactly 3 entries"), std::string::npos) << said;
  }
}

TEST(LinkScenes, AFluidOnAGridIsRefused) {
  PairTable table = standard_pairs();
  Json scene = Json::parse(pair_scene_text(table, table.find("plane"), table.find("grid_fluid")));
  scene["attachments"] = {{{"name", "pin"}, {"body", "upper"}, {"point", {0, 0, 0.1}}}};
  EXPECT_NE(message(scene.dump()).find("no points that a link can hold"), std::string::npos) << message(scene.dump());
}

TEST(LinkScenes, GravityScalesForEveryKind) {
  PairTable table = standard_pairs();
  for (const PairKind& upper : table.kinds) {
    if (fixed(upper)) continue;
    Json scene = Json::parse(pair_scene_text(table, table.find("plane"), upper));
    scene["world"]["gravity"] = {0, 0, -9.81};
    scene["bodies"][0]["transform"] = {{"position", {0, 0, -5}}};
    scene["bodies"][1].erase("velocity");
    scene["forces"] = {{{"name", "float"}, {"bodies", {"up*"}}, {"gravity_scale", 0.5}}};
    World w = build_world(parse_scene(scene.dump()));
    for (int s = 0; s < 10; ++s) ASSERT_TRUE(w.step().ok) << upper.name;
    const double v = w.body(1).linear_momentum(w.v(1)).z() / w.body(1).mass();
    EXPECT_NEAR(v, -0.5 * 9.81 * w.state().time, 0.02 * 9.81 * w.state().time) << upper.name;
  }
}

TEST(LinkScenes, ForcesAndTorquesOfABodyAreWhatItsMomentaGain) {
  PairTable table = standard_pairs();
  for (const PairKind& upper : table.kinds) {
    if (fixed(upper) || upper.name == "grid_fluid") continue;
    Json scene = Json::parse(pair_scene_text(table, table.find("plane"), upper));
    scene["bodies"][0]["transform"] = {{"position", {0, 0, -5}}};
    scene["bodies"][1].erase("velocity");
    scene["forces"] = {{{"name", "push"}, {"bodies", {"upper"}}, {"force", {1, 2, 3}}, {"torque", {0, 0, 0.05}}}};
    World w = build_world(parse_scene(scene.dump()));
    ASSERT_TRUE(w.step().ok) << upper.name;
    const double t = w.state().time;
    const Vec3 p = w.body(1).linear_momentum(w.v(1));
    EXPECT_LT((p - t * Vec3(1, 2, 3)).norm(), 1e-6 * t) << upper.name;
    const double m = w.body(1).mass();
    std::vector<double> motion(w.body(1).v_size());
    if (!w.body(1).rigid_motion(Vec3::UnitX(), Vec3::Zero(), motion)) continue;
    const double z = w.body(1).angular_momentum(motion).y() / m;
    w.body(1).rigid_motion(Vec3::UnitY(), Vec3::Zero(), motion);
    const double x = w.body(1).angular_momentum(motion).z() / m;
    w.body(1).rigid_motion(Vec3::UnitZ(), Vec3::Zero(), motion);
    const double y = w.body(1).angular_momentum(motion).x() / m;
    const Vec3 spin = w.body(1).angular_momentum(w.v(1)) - Vec3(x, y, z).cross(p);
    EXPECT_NEAR(spin.z(), 0.05 * t, 0.02 * 0.05 * t) << upper.name;
  }
}

const char* kTwo = R"("brim": 1, "name": "two", "duration": 1, "bodies": [
  {"kind": "rigid", "name": "a.b", "shape": {"kind": "sphere", "radius": 0.2}},
  {"kind": "rigid", "name": "c", "shape": {"kind": "sphere", "radius": 0.2}, "transform": {"position": [0.3, 0, 0]}}])";

TEST(LinkScenes, GroupsStandForTheirNamesInFilters) {
  const std::string head = std::string("{") + kTwo + R"(, "world": {"gravity": [0, 0, 0]}, )";
  EXPECT_GT(build_world(parse_scene(head + R"("filters": []})")).step().contacts, 0);
  EXPECT_EQ(build_world(parse_scene(head + R"("groups": {"g": ["a*", "a.b"]}, "filters": [{"between": ["g", "c"]}]})"))
                .step()
                .contacts,
            0);
}

TEST(LinkScenes, BadOnesAreRefusedWithTheirPlace) {
  const std::string head = std::string("{") + kTwo + ", ";
  const auto expect = [&](const std::string& keys, const std::vector<std::string>& words) {
    const std::string text = message(head + keys + "}");
    for (const std::string& word : words)
      EXPECT_NE(text.find(word), std::string::npos) << keys << ": \"" << text << "\" lacks \"" << word << "\"";
  };
  expect(R"("attachments": [{"name": "x", "body": "d", "point": [0, 0, 0]}])",
         {"/attachments/0", "\"d\" is not a body"});
  expect(R"("attachments": [{"name": "x", "body": "c"}])", {"/attachments/0", "\"point\" or \"region\""});
  expect(
      R"("attachments": [{"name": "x", "body": "c", "point": [0, 0, 0], "to": "a.b", "keyframes": [{"time": 0}, {"time": 1}]}])",
      {"/attachments/0/keyframes"});
  expect(R"("attachments": [{"name": "x", "body": "c", "point": [0, 0, 0], "stiffness": -1}])", {"/stiffness"});
  expect(R"("forces": [{"name": "x", "bodies": ["d"]}])", {"/forces/0", "no body"});
  expect(R"("forces": [{"name": "x", "scale": [{"time": 1, "value": 1}, {"time": 1, "value": 2}]}])",
         {"/scale/1/time"});
  expect(R"("filters": [{"between": ["c"]}])", {"/filters/0/between"});
}

TEST(LinkScenes, AFilterThatNamesNoBodyIsRefusedWithTheNearestName) {
  const std::string head =
      R"({"brim": 1, "name": "three", "duration": 1, "groups": {"all": ["ball", "bo*"], "off": ["ball", "boll"]}, "bodies": [
    {"kind": "rigid", "name": "ball", "shape": {"kind": "sphere", "radius": 0.1}},
    {"kind": "rigid", "name": "box", "repeat": {"count": [2, 1, 1], "spacing": [1, 1, 1]},
     "transform": {"position": [0, 3, 0]}, "shape": {"kind": "sphere", "radius": 0.1}}], "filters": [)";
  const auto said = [&](const std::string& between) { return message(head + R"({"between": )" + between + "}]}"); };
  for (const char* good :
       {R"(["ball", "box"])", R"(["box.1", "b*"])", R"(["all", "*"])", R"(["ball", "box.?"])", R"(["ball", "ball"])"})
    EXPECT_EQ(said(good), "") << good;
  const struct {
    const char* between;
    std::vector<std::string> words;
  } bad[] = {{R"(["bal", "box"])", {"/filters/0/between/0", "\"bal\" is not a body", "did you mean \"ball\"?"}},
             {R"(["ball", "bix"])", {"/filters/0/between/1", "did you mean \"box\"?"}},
             {R"(["ball", "box.7"])", {"/filters/0/between/1", "\"box.7\""}},
             {R"(["c*", "box"])", {"/filters/0/between/0", "\"c*\"", "must match"}},
             {R"(["off", "box"])", {"/groups/off/1", "\"boll\"", "did you mean \"ball\"?"}},
             {R"(["al", "box"])", {"did you mean"}}};
  for (const auto& b : bad)
    for (const std::string& word : b.words)
      EXPECT_NE(said(b.between).find(word), std::string::npos) << b.between << ": " << said(b.between);
}

TEST(LinkScenes, AHingeAboutARodsOwnAxisHasNoDrive) {
  const std::string head =
      R"({"brim": 1, "name": "axle", "duration": 1, "world": {"voxel_size": 0.02, "gravity": [0, 0, 0]}, "bodies": [
    {"kind": "rod", "name": "rod", "points": [[-0.3, 0, 0], [0.3, 0, 0]], "segments": 12, "radius": 0.02, "linear_density": 1}], "joints": [{"name": "axle", "kind": "revolute", "body": "rod", "position": [0, 0, 0], "axis": )";
  const std::string drive = R"(, "drive": {"target_velocity": 1, "damping": 0.1})", damping = R"(, "damping": 0.1)";
  for (const std::string& acts : {drive, damping, std::string(R"(, "upper": 1)")}) {
    const std::string text = message(head + "[1, 0, 0]" + acts + "}]}");
    for (const char* word : {"/joints/0", "'axle'", "beside its axis", "turn the axis"})
      EXPECT_NE(text.find(word), std::string::npos) << acts << ": " << text;
  }
  World w = build_world(parse_scene(head + "[1, 0, 0]}]}"));  // holds it all the same
  for (int s = 0; s < 5; ++s) ASSERT_TRUE(w.step().ok);
}

}  // namespace
}  // namespace brim::links_test
