#include "brim/scene/pairs/pair_page.h"

#include <gtest/gtest.h>

/// The page of pairs, from results that are made up.
namespace brim::pair_page_test {
namespace {

PairResult result(const std::string& upper, const std::string& lower, const std::string& failure = "") {
  PairResult r;
  r.upper = upper;
  r.lower = lower;
  if (!failure.empty()) r.failures = {failure};
  return r;
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

PairTable table_with(const std::vector<PairNote>& notes) {
  PairTable table = standard_pairs();
  table.notes = notes;
  return table;
}

TEST(PairPage, EachPairThatFailsIsExplainedByTheFirstNoteAboutItAlone) {
  const PairTable table = table_with({{{"rod on cloth"}, "thin"}, {{"cloth"}, "soft"}, {{"mesh"}, "never needed"}});
  const std::string why = why_some_fail({table,
                                         {result("rod", "cloth", "moves"), result("cloth", "rigid", "moves"),
                                          result("cloth", "plane"), result("points", "plane", "moves")}});
  EXPECT_EQ(why,
            "- **rod on cloth**: thin\n"
            "- **cloth on rigid**: soft\n"
            "- **points on plane**: the table of kinds does not say why.\n");
}

TEST(PairPage, APairIsNamedByWhatFliesOnWhat) {
  const PairNote note = {{"rod on cloth"}, "thin"};
  EXPECT_TRUE(note.about("cloth", "rod"));
  EXPECT_FALSE(note.about("rod", "cloth"));
  EXPECT_FALSE(note.about("rod", "rod"));
}

TEST(PairPage, FurtherWorldsHaveTheirOwnMatrixCountAndReasons) {
  PairTable table = table_with({{{"rigid"}, "in free space"}});
  const PairTable rest = table.in_world("rest");
  const std::vector<PairRun> runs = {{table, {result("rigid", "plane", "moves"), result("rod", "plane")}},
                                     {rest, {result("rigid", "plane"), result("points", "points", "grew")}}};
  const std::string page = pairs_markdown(runs, "brim pairs -o page.md");
  EXPECT_NE(page.find("`brim pairs -o page.md` made this page"), std::string::npos);
  EXPECT_NE(page.find("**1 of 2 pairs are good**"), std::string::npos);
  EXPECT_NE(page.find("- **rigid on plane**: in free space"), std::string::npos);
  EXPECT_EQ(count(page, "## Other worlds"), 1u);
  const std::string further = page.substr(page.find("### rest"));
  EXPECT_NE(further.find("**1 of 2 are good**"), std::string::npos);
  EXPECT_NE(further.find("- **points on points**: "), std::string::npos);
  EXPECT_NE(further.find("| points | points |"), std::string::npos) << "figures of those that fail";
  EXPECT_EQ(further.find("| rigid | plane |"), std::string::npos) << "those that are good have none there";
  EXPECT_EQ(count(page, "| 9 points |"), 2u) << "a matrix each";
}

TEST(PairPage, APageOfOneWorldWhereAllIsGoodSaysNothingMore) {
  const std::string page = pairs_markdown(std::vector<PairRun>{{standard_pairs(), {result("rigid", "plane")}}}, "");
  EXPECT_EQ(page.find("Why some fail"), std::string::npos);
  EXPECT_EQ(page.find("Other worlds"), std::string::npos);
  EXPECT_EQ(page.find("by constraints"), std::string::npos);
}

TEST(PairPage, UnderConstraintsTheNotesOfConstraintsAreTaken) {
  PairTable table = standard_pairs();
  table.notes = {{{"rigid"}, "of penalties"}};
  table.constraint_notes = {{{"rigid"}, "of rows"}};
  for (PairWorld& world : table.worlds) {
    world.notes = {{{"rigid"}, "of penalties there"}};
    world.constraint_notes = {{{"rigid"}, "of rows there"}};
  }
  table.set_response("constraint");
  const std::vector<PairRun> runs = {{table, {result("rigid", "plane", "moves")}},
                                     {table.in_world("fine"), {result("rigid", "plane", "moves")}}};
  const std::string page = pairs_markdown(runs, "");
  EXPECT_NE(page.find("by constraints"), std::string::npos);
  EXPECT_NE(page.find("of rows\n"), std::string::npos);
  EXPECT_NE(page.find("of rows there\n"), std::string::npos);
  EXPECT_EQ(page.find("of penalties"), std::string::npos);
}

TEST(PairPage, KindsThatAreAddedBringTheirNotesOfEveryWorldThatTheTableHas) {
  PairTable table = standard_pairs(), mine;
  mine.notes = {{{"mine on rod"}, "first"}};
  mine.worlds.resize(2);
  mine.worlds[0].name = "rest";
  mine.worlds[0].notes = {{{"mine on rod"}, "resting"}};
  mine.worlds[1].name = "elsewhere";
  const std::size_t worlds = table.worlds.size();
  table.add_kinds(mine);
  EXPECT_EQ(table.worlds.size(), worlds);
  EXPECT_EQ(table.notes.back().why, "first");
  EXPECT_EQ(table.in_world("rest").notes.back().why, "resting");
}

}  // namespace
}  // namespace brim::pair_page_test
