#include <gtest/gtest.h>

#include <algorithm>

#include "brim/core/error.h"
#include "brim/scene/pairs/pair_page.h"
#include "brim/scene/pairs/pair_report.h"
#include "brim/scene/pairs/pair_trial.h"
#include "brim/scene/scene.h"

/// The table of pairs: what it reads, what it measures, and a few of its cells.
namespace brim::pairs_test {
namespace {

/// A ball on a ball, small and quick.
std::string small_table(const std::string& bounds, const std::string& upper_extra = "") {
  return R"({"brim": 1, "drop": {"steps": 80, "gap": 0.01},
    "world": {"gravity": [0, 0, 0], "time_step": 0.005, "voxel_size": 0.02, "stiffness": 2e5, "max_substeps": 1,
              "friction_speed": 1e-4, "cg_tolerance": 1e-6},
    "bounds": {)" +
         bounds + R"(}, "kinds": [
    {"name": "ground", "lowest": -1, "highest": 0, "body": {"kind": "obstacle", "shape": {"kind": "plane", "display_size": 1}}},
    {"name": "ball", "lowest": -0.1, "highest": 0.1,
     "body": {"kind": "rigid", "density": 500, "shape": {"kind": "sphere", "radius": 0.1})" +
         upper_extra + "}}]}";
}

std::string message_of(const std::string& text) {
  try {
    read_pair_table(text, "table.json");
  } catch (const InputError& e) {
    return e.what();
  }
  return "no error";
}

TEST(Pairs, ABallBouncesOffAnEqualBallAndBothFeelIt) {
  const PairTable table = read_pair_table(small_table(""), "table.json");
  const PairResult r = run_pair(table, table.find("ball"), table.find("ball"));
  EXPECT_TRUE(r.ok()) << pair_line(r);
  EXPECT_GT(r.contacts, 0);
  // Equal and opposite, by the momentum that each gained.
  EXPECT_GT(r.force_upper, 1.0);
  EXPECT_NEAR(r.force_upper, r.force_lower, 1e-4 * r.force_upper);
  EXPECT_LT(r.drift, 1e-5);
  EXPECT_GT(r.overlap, 0.0);
  EXPECT_EQ(r.leak, 0.0);
}

TEST(Pairs, WhatNothingMovesIsAlwaysBelowAndTwoSuchAreNotRun) {
  const PairTable table = read_pair_table(small_table(""), "table.json");
  const PairResult r = run_pair(table, table.find("ball"), table.find("ground"));
  EXPECT_EQ(r.lower, "ground");
  EXPECT_EQ(r.upper, "ball");
  EXPECT_TRUE(r.ok()) << pair_line(r);
  EXPECT_FALSE(run_pair(table, table.find("ground"), table.find("ground")).run);
}

TEST(Pairs, UnderConstraintsTheSamePairsHaveNoOverlapToSpeakOf) {
  PairTable table = standard_pairs();
  const PairResult soft = run_pair(table, table.find("rigid"), table.find("rigid"));
  table.set_response("constraint");
  const PairResult hard = run_pair(table, table.find("rigid"), table.find("rigid"));
  EXPECT_TRUE(hard.ok()) << hard.failures.front();
  EXPECT_GT(hard.contacts, 0);
  EXPECT_LT(hard.overlap, 0.5 * soft.overlap);
}

TEST(Pairs, SoftBodiesBounceOffUnderConstraintsWithoutGainingEnergy) {
  PairTable table = standard_pairs();
  table.set_response("constraint");
  for (const auto& [lower, upper] : {std::pair("plane", "mass_spring"), std::pair("mass_spring", "finite_elements")}) {
    const PairResult r = run_pair(table, table.find(lower), table.find(upper));
    EXPECT_TRUE(r.ok()) << upper << " on " << lower << ": " << r.failures.front();
  }
}

TEST(Pairs, ByRowsTheAxisOfAThinLinkPushesNothingThatIsALevelCoarser) {
  // The capsules' radius is one coarse voxel: at nodes on their axes the gradient points along the chain.
  PairTable table = standard_pairs();
  table.set_response("constraint");
  const PairTable levels = table.in_world("levels");
  for (const char* upper : {"meshless", "soft_image"}) {
    const PairResult r = run_pair(levels, levels.find("articulated"), levels.find(upper));
    EXPECT_TRUE(r.ok()) << pair_line(r);
    EXPECT_LE(r.energy, 1e-3) << upper;
  }
}

TEST(Pairs, ByRowsSlippingSheetsAndChainsAtRestAreSolved) {
  PairTable table = standard_pairs();
  table.set_response("constraint");
  const PairResult blow = run_pair(table, table.find("mass_spring"), table.find("cloth"));
  EXPECT_TRUE(blow.ok()) << pair_line(blow);
  const PairTable rest = table.in_world("rest");
  for (const char* upper : {"rod", "rigid_image", "meshless"}) {
    const PairResult r = run_pair(rest, rest.find("articulated"), rest.find(upper));
    EXPECT_TRUE(r.ok()) << pair_line(r);
  }
}

TEST(Pairs, AMissedBoundIsNamed) {
  const PairTable table = read_pair_table(small_table(R"("overlap": 0.01)"), "table.json");
  const PairResult r = run_pair(table, table.find("ball"), table.find("ball"));
  ASSERT_EQ(r.failures.size(), 1u) << pair_line(r);
  EXPECT_NE(r.failures[0].find("overlap"), std::string::npos);
  const std::vector<PairResult> results = {r};
  EXPECT_NE(pairs_markdown(std::vector<PairRun>{{table, results}}, "brim pairs").find("✗ overlap"), std::string::npos);
  EXPECT_NE(pairs_json(table, results).find("\"ok\": false"), std::string::npos);
}

TEST(Pairs, ABodyThatPassesThroughHasLeaked) {
  // Contact too soft to hold a fast ball: it is through before it is stopped.
  std::string text = small_table("");
  text.replace(text.find("2e5"), 3, "1e1");
  const PairTable table = read_pair_table(text, "table.json");
  const PairResult r = run_pair(table, table.find("ball"), table.find("ground"));
  EXPECT_GT(r.leak, 0.5) << pair_line(r);
  EXPECT_FALSE(r.ok());
}

TEST(Pairs, ABodyThatMissesHasNoContact) {
  std::string text = small_table("");
  text.replace(text.find("\"gap\": 0.01"), 11, "\"gap\": 0.01, \"offset\": [0.5, 0]");
  const PairTable table = read_pair_table(text, "table.json");
  const PairResult r = run_pair(table, table.find("ball"), table.find("ball"));
  ASSERT_FALSE(r.ok());
  EXPECT_EQ(r.failures[0], "no contact");
}

/// A soft block on soft ground, in a world of the table with gravity, a floor and finer voxels.
std::string table_with_worlds() {
  std::string text = small_table("");
  text.insert(text.find("\"bounds\""),
              R"("worlds": {"rest": {"about": "on a floor", "floor": true, "steps": 160, "voxel_size": 0.025,
    "world": {"gravity": [0, 0, -9.81], "stiffness": null}}}, )");
  text.insert(text.rfind("]}"), R"(, {"name": "block", "lowest": -0.1, "highest": 0.1,
     "body": {"kind": "rigid", "voxel_size": 0.02, "density": 500, "shape": {"kind": "box", "size": [0.3, 0.3, 0.2]}}})");
  return text;
}

TEST(Pairs, AWorldOfTheTableChangesWhatItNames) {
  const PairTable table = read_pair_table(table_with_worlds(), "table.json"), rest = table.in_world("rest");
  EXPECT_EQ(rest.name, "rest");
  EXPECT_EQ(rest.drop.steps, 160);
  EXPECT_NE(rest.world.find("0.025"), std::string::npos);
  EXPECT_EQ(rest.world.find("stiffness"), std::string::npos);
  EXPECT_NE(rest.find("block").body.find("0.025"), std::string::npos);
  EXPECT_NE(pair_scene_text(rest, rest.find("block"), rest.find("block")).find("floor"), std::string::npos);
  EXPECT_EQ(pair_scene_text(table, table.find("block"), table.find("block")).find("floor"), std::string::npos);
  EXPECT_THROW(table.in_world("rset"), InputError);
}

TEST(Pairs, ABlockComesToRestOnAnotherWhichCarriesIt) {
  const PairTable rest = read_pair_table(table_with_worlds(), "table.json").in_world("rest");
  const PairResult r = run_pair(rest, rest.find("block"), rest.find("block"));
  EXPECT_TRUE(r.ok()) << pair_line(r);
  EXPECT_NEAR(r.carried, 1.0, 0.02);
  EXPECT_LT(r.speed, 0.01);
  EXPECT_LE(r.motion, 1e-9);
  EXPECT_LT(r.drift, 1e-3);
}

TEST(Pairs, ABlockThatIsStillFallingIsNotAtRest) {
  PairTable rest = read_pair_table(table_with_worlds(), "table.json").in_world("rest");
  rest.drop.steps = 2;
  const PairResult early = run_pair(rest, rest.find("block"), rest.find("block"));
  EXPECT_NE(pair_line(early).find("moves at"), std::string::npos) << pair_line(early);
  rest.cut(1);
  EXPECT_EQ(pair_line(run_pair(rest, rest.find("block"), rest.find("block"))).find("moves at"), std::string::npos);
}

TEST(Pairs, BadTablesAreRefusedWithWhatIsAllowed) {
  EXPECT_NE(message_of("{}").find("\"brim\" is missing"), std::string::npos);
  EXPECT_NE(message_of(small_table(R"("overlaps": 1)")).find("did you mean \"overlap\"?"), std::string::npos);
  EXPECT_NE(message_of(small_table("", R"(, "velocity": [0, 0, 1])")).find("leave it out"), std::string::npos);
  std::string twice = small_table("");
  twice.replace(twice.find("\"ground\""), 8, "\"ball\"");
  EXPECT_NE(message_of(twice).find("given twice"), std::string::npos);
  try {
    standard_pairs().find("rigit");
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("did you mean \"rigid\"?"), std::string::npos);
  }
}

TEST(Pairs, EveryKindOfTheStandardTableBuildsInAScene) {
  for (const PairKind& kind : standard_pairs().kinds) {
    SCOPED_TRACE(kind.name);
    const World world = build_world(parse_scene(pair_scene_text(standard_pairs(), kind, kind), kind.name));
    EXPECT_EQ(world.body_count(), 2);
  }
}

/// The table in short: every fast kind on a ball and on a soft block. `brim pairs` runs all.
TEST(Pairs, KindsThatAreQuickToRunMeetABallAndASoftBlock) {
  PairTable table = standard_pairs();
  std::vector<PairKind> quick;
  for (const char* name : {"plane", "mesh", "rigid", "articulated", "mass_spring", "rod", "points", "rigid_image"})
    quick.push_back(table.find(name));
  for (const char* lower : {"rigid", "finite_elements"})
    for (const PairKind& kind : quick) {
      const PairResult r = run_pair(table, table.find(lower), kind);
      EXPECT_TRUE(r.ok()) << pair_line(r);
    }
}

}  // namespace
}  // namespace brim::pairs_test
