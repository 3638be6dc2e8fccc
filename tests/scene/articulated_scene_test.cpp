#include <gtest/gtest.h>

#include <algorithm>

#include "brim/core/error.h"
#include "brim/scene/scene.h"
#include "checkout_paths.h"

/// Scenes with trees of links: what they build, and what is refused.
namespace brim::articulated_scene_test {
namespace {

const char* const kGood = R"({
  "brim": 1, "name": "arm", "duration": 0.1, "world": {"gravity": [0, 0, -9.81]},
  "bodies": [
    {"kind": "articulated", "name": "arm", "transform": {"position": [0, 0, 2], "scale": 2},
     "links": [
      {"name": "base", "shape": {"kind": "box", "size": [0.2, 0.2, 0.1]}},
      {"name": "upper", "parent": "base", "shape": {"kind": "box", "size": [1, 0.1, 0.1]}, "mass": 5,
       "transform": {"position": [0.5, 0, 0]},
       "joint": {"kind": "revolute", "axis": [0, 1, 0], "lower": -1, "upper": 1, "start": 0.5}},
      {"name": "lower", "parent": "upper", "shape": {"kind": "box", "size": [1, 0.1, 0.1]}, "density": 300,
       "transform": {"position": [0.5, 0, 0]},
       "joint": {"kind": "ball", "position": [1, 0, 0], "upper": 2, "drive": {"stiffness": 10}}}
     ],
     "no_contact": [["base", "lower"]]},
    {"kind": "articulated", "name": "chain", "base": "free", "velocity": [1, 0, 0],
     "chain": {"links": 5, "length": 0.2, "radius": 0.05}, "repeat": {"count": [1, 2, 1], "spacing": [1, 1, 1]}},
    {"kind": "articulated", "name": "robot", "urdf": "models/gripper.urdf", "joints": [{"joint": "lift", "start": 0.1}]}
  ]
}
)";

std::string file() { return std::string(BRIM_SOURCE_DIR) + "/scenes/arm.json"; }

std::string message(const std::string& text) {
  try {
    build_world(parse_scene(text, file()));
    return "";
  } catch (const InputError& e) {
    return e.what();
  }
}

TEST(ArticulatedScene, LinksChainAndFileBecomeBodies) {
  World w = build_world(parse_scene(kGood, file()));
  ASSERT_EQ(w.body_count(), 4);
  EXPECT_EQ(w.body(0).part_count(), 3);
  EXPECT_FALSE(w.body(0).parts_collide(0, 2));
  EXPECT_EQ(w.q(0).size(), 5u);
  EXPECT_EQ(w.q(0)[0], 0.5);
  EXPECT_NEAR(w.body(0).mass(), 1000 * 0.4 * 0.4 * 0.2 + 5 + 300 * 2 * 0.2 * 0.2, 1e-9);
  // The upper arm starts at the base and reaches 2 m, turned down by 0.5 rad.
  const Vec3 middle = w.body(0).bounds(1).center();
  EXPECT_LT((middle - Vec3(std::cos(0.5), 0, 2 - std::sin(0.5))).norm(), 1e-12);
  EXPECT_EQ(w.body(1).part_count(), 5);
  EXPECT_EQ(w.v(1)[0], 1.0);
  EXPECT_NEAR((w.body(2).bounds(0).center() - w.body(1).bounds(0).center()).y(), 1.0, 1e-12);
  EXPECT_EQ(w.body(3).part_count(), 4);
  EXPECT_NEAR(w.body(3).bounds(0).center().z(), 0.1, 1e-12) << "the palm, lifted";
  EXPECT_TRUE(w.step().ok);
}

TEST(ArticulatedScene, DrivesThatCannotReachTheirTargetAreRefused) {
  const auto with = [](const std::string& drive) {
    std::string text = kGood;
    const std::string find = "\"drive\": {\"stiffness\": 10}";
    return message(text.replace(text.find(find), find.size(), "\"drive\": " + drive));
  };
  const char* const keys = R"("keyframes": [{"time": 0, "target": 0}, {"time": 1, "target": 1}])";
  for (const std::string& good :
       {std::string("{}"), std::string(R"({"force_limit": 2})"), std::string(R"({"stiffness": 5, "target": 1})"),
        std::string(R"({"damping": 5, "target_velocity": 1})"), std::string(R"({"damping": 5, "target": 0})"),
        fmt::format(R"({{"damping": 5, {}}})", keys)})
    EXPECT_EQ(with(good), "") << good;
  const auto refused = [&](const std::string& drive, const char* has, const char* lacks) {
    const std::string text = with(drive);
    for (const char* word : {"/bodies/0/links/2/joint/drive", has, lacks})
      EXPECT_NE(text.find(word), std::string::npos) << drive << ": " << text;
  };
  refused(R"({"target": 1})", "\"target\"", "no \"stiffness\"");
  refused(R"({"target": 0})", "\"target\"", "no \"stiffness\"");
  refused(R"({"target_velocity": 0})", "\"target_velocity\"", "no \"damping\"");
  refused(R"({"target": 1, "damping": 3})", "\"target\"", "no \"stiffness\"");
  refused(R"({"target_velocity": 1, "stiffness": 3})", "\"target_velocity\"", "no \"damping\"");
  refused(fmt::format("{{{}}}", keys), "\"keyframes\"", "no \"stiffness\" or \"damping\"");
}

TEST(ArticulatedScene, MistakesAreRefusedWithTheirPlace) {
  struct Case {
    const char *find, *replace, *place, *word;
  };
  for (const Case& c : {
           Case{"\"parent\": \"upper\"", "\"parent\": \"uper\"", "/bodies/0/links/2/parent", "did you mean \"upper\""},
           Case{"\"name\": \"lower\"", "\"name\": \"upper\"", "/bodies/0/links/2/name", "already"},
           Case{"\"lower\": -1", "\"lower\": 3", "/bodies/0/links/1/joint/lower", "at most"},
           Case{"\"start\": 0.5", "\"start\": 1.5", "/bodies/0/links/1/joint/start", "from -1 to 1"},
           Case{"\"start\": 0.1", "\"start\": 9", "/bodies/2/joints/0/start", "within the limits"},
           Case{"\"axis\": [0, 1, 0]", "\"axis\": [0, 0, 0]", "/bodies/0/links/1/joint/axis", "no direction"},
           Case{"\"mass\": 5", "\"mass\": 5, \"density\": 5", "/bodies/0/links/1/mass", "give one"},
           Case{"\"kind\": \"ball\"", "\"kind\": \"hinge\"", "/bodies/0/links/2/joint/kind", "ball"},
           Case{"\"kind\": \"ball\"", "\"kind\": \"fixed\"", "/bodies/0/links/2/joint/upper", "fixed joint"},
           Case{"\"radius\": 0.05", "\"radius\": 0.15", "/bodies/1/chain", "half"},
           Case{"\"base\": \"free\", ", "", "/bodies/1/velocity", "free base"},
           Case{"\"chain\": {", "\"urdf\": \"x\", \"chain\": {", "/bodies/1", "exactly one"},
           Case{"[\"base\", \"lower\"]", "[\"base\", \"low\"]", "/bodies/0/no_contact/0/1", "not a link"},
           Case{"gripper.urdf", "none.urdf", "/bodies/2/urdf", "no such file"},
           Case{"\"joint\": \"lift\"", "\"joint\": \"left\"", "/bodies/2/joints/0/joint", "did you mean \"lift\""},
           Case{"\"name\": \"robot\"", "\"name\": \"robot\", \"transform\": {\"scale\": 2}",
                "/bodies/2/transform/scale", "must be 1"},
           Case{"\"mass\": 5,", "\"mass\": 5, \"parents\": 1,", "/bodies/0/links/1/parents", "unknown key"},
       }) {
    std::string text = kGood;
    const auto at = text.find(c.find);
    ASSERT_NE(at, std::string::npos) << c.find;
    const std::string m = message(text.replace(at, std::string(c.find).size(), c.replace));
    EXPECT_NE(m.find(c.place), std::string::npos) << c.replace << ": " << m;
    EXPECT_NE(m.find(c.word), std::string::npos) << c.replace << ": " << m;
    EXPECT_EQ(m.find('\n'), std::string::npos) << "one line";
  }
}

TEST(ArticulatedScene, ABodyInWhichNothingMovesIsRefused) {
  const std::string m = message(R"({"brim": 1, "name": "x", "duration": 1, "bodies": [
    {"kind": "articulated", "name": "a", "links": [{"name": "l", "shape": {"kind": "sphere", "radius": 1}}]}]})");
  EXPECT_NE(m.find("no joint can move"), std::string::npos) << m;
}

TEST(ArticulatedScene, AJointThatMovesNothingIsRefused) {
  const std::string m = message(R"({"brim": 1, "name": "x", "duration": 1, "bodies": [
    {"kind": "articulated", "name": "a", "links": [{"name": "l", "joint": {"kind": "revolute"}}]}]})");
  EXPECT_NE(m.find("armature"), std::string::npos) << m;
}

}  // namespace
}  // namespace brim::articulated_scene_test
