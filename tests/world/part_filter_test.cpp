#include "brim/world/part_filter.h"

#include <gtest/gtest.h>

#include "brim/body/grid_fluid/grid_fluid_body.h"
#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "support/soft_worlds.h"

/// Rules of which parts of bodies touch. What scenes say of them: tests/scene/links_test.cpp.
namespace brim::part_filter_test {
namespace {

using testing::position;
using testing::run;

bool west(const Vec3& x) { return x.x() < -1e-9; }
bool nowhere(const Vec3&) { return false; }
bool everywhere(const Vec3&) { return true; }

TouchRule apart(const std::string& a, const std::string& b, bool (*region)(const Vec3&)) {
  return {a, b, false, region, {}};
}

WorldOptions options(std::vector<TouchRule> rules, Response response = Response::Penalty) {
  WorldOptions o = testing::options_at(0.1);
  o.touch_rules = std::move(rules);
  o.response = response;
  return o;
}

/// Heights of the lowest node of a sheet with x < −border, and with x > border.
std::pair<double, double> lowest_of(const World& w, int b, const std::vector<double>& start, double border) {
  std::pair<double, double> least(1e9, 1e9);
  const auto q = w.q(b);
  for (std::size_t i = 0; i < q.size(); i += 3) {
    if (start[i] < -border) least.first = std::min(least.first, q[i + 2]);
    if (start[i] > border) least.second = std::min(least.second, q[i + 2]);
  }
  return least;
}

TEST(PartFilter, TheHalfOfASheetThatIsCutOffFallsThroughAndTheRestLies) {
  World w(options({apart("sheet", "ground", west)}));
  w.add(testing::ground(0.8));
  w.add(testing::sheet("sheet", 1.2, Vec3(0, 0, 0.1)));
  const std::vector<double> start(w.q(1).begin(), w.q(1).end());
  run(w, 0.25);
  const auto [cut, rest] = lowest_of(w, 1, start, 0.35);
  EXPECT_LT(cut, -0.1) << "it hangs through";
  EXPECT_GT(rest, -0.02) << "it lies";
}

TEST(PartFilter, ARegionWithoutMatterChangesNoBit) {
  std::uint64_t hash[2];
  for (int k = 0; k < 2; ++k) {
    World w(options(k == 0 ? std::vector<TouchRule>{} : std::vector<TouchRule>{apart("*", "*", nowhere)}));
    w.add(testing::ground(0.5));
    w.add(testing::jelly("jelly", 0.5, Vec3(-0.25, -0.25, 0.0)));
    w.add(testing::sheet("sheet", 0.8, Vec3(0, 0, 0.56)));
    w.add(testing::box("box", {Vec3(0.02, 0.01, 0.78)}, 0.5, 0.3, 300));
    run(w, 0.2);
    hash[k] = w.hash();
  }
  EXPECT_EQ(hash[0], hash[1]);
}

TEST(PartFilter, ARegionOfAllMatterIsTheRuleOfTheWholeBody) {
  std::uint64_t hash[2];
  for (int k = 0; k < 2; ++k) {
    World w(options({k == 0 ? TouchRule{"box", "ground", false} : apart("box", "ground", everywhere)}));
    w.add(testing::ground(0.5));
    w.add(testing::box("box", {Vec3(0, 0, 0.55)}));
    run(w, 0.5);
    EXPECT_NEAR(position(w, 1).z(), 0.55 - 0.5 * 9.81 * 0.25, 0.05);
    hash[k] = w.hash();
  }
  EXPECT_EQ(hash[0], hash[1]);
}

TEST(PartFilter, MomentumIsKeptByWhatIsLeft) {
  for (const bool soft : {false, true}) {
    WorldOptions o = options({apart("upper", "lower", west)});
    o.environment.gravity = Vec3::Zero();
    World w(o);
    testing::Start s;
    s.x = Vec3(0, 0, 0.31), s.v = Vec3(0.2, 0, -2.0);
    w.add(soft ? testing::jelly("lower", 0.4, Vec3(-0.2, -0.2, -0.2)) : testing::box("lower", {}, 0.5, 0.4, 500));
    w.add(testing::box("upper", s, 0.5, 0.2, 500));
    const Vec3 before = w.body(0).linear_momentum(w.v(0)) + w.body(1).linear_momentum(w.v(1));
    bool touched = false;
    for (int i = 0; i < 15; ++i) {
      const StepReport r = w.step();
      ASSERT_TRUE(r.ok);
      EXPECT_LT(r.momentum_error, 1e-12);
      touched = touched || r.contacts > 0;
    }
    EXPECT_TRUE(touched);
    EXPECT_GT(testing::spin(w, 1).norm(), 0.2) << "it is pushed on one side alone";
    const Vec3 after = w.body(0).linear_momentum(w.v(0)) + w.body(1).linear_momentum(w.v(1));
    EXPECT_LT((after - before).norm(), 1e-9 * before.norm());
  }
}

TEST(PartFilter, ASolidSinksInAsFarAsItIsCutUnderBothResponses) {
  for (const Response response : {Response::Penalty, Response::Constraint}) {
    // A box of 1 m whose lower half touches nothing: it comes to rest with the cut near the ground.
    World w(options({{"box", "ground", false, [](const Vec3& x) { return x.z() < 0.6; }, {}}}, response));
    w.add(testing::ground(0.5));
    w.add(testing::box("box", {Vec3(0, 0, 0.6)}));
    double most_overlap = 0.0;
    for (int i = 0; i < 120; ++i) {
      const StepReport r = w.step();
      ASSERT_TRUE(r.ok);
      for (const Warning& warning : r.warnings) EXPECT_NE(warning.code, "engulfed") << warning.message;
      most_overlap = std::max(most_overlap, r.worst_overlap);
    }
    // The inside is dense: the ground is felt half a ramp, 1.5 voxels, early.
    EXPECT_NEAR(position(w, 1).z(), 0.075, 0.125) << static_cast<int>(response);
    EXPECT_LT(testing::velocity(w, 1).norm(), 0.02) << static_cast<int>(response);
  }
}

TEST(PartFilter, ARegionOfEitherSideMeansTheSame) {
  std::uint64_t hash[2];
  for (int k = 0; k < 2; ++k) {
    World w(options(
        {k == 0 ? TouchRule{"sheet", "ground", false, west, {}} : TouchRule{"ground", "sheet", false, {}, west}}));
    w.add(testing::ground(0.5));
    w.add(testing::sheet("sheet", 1.2, Vec3(0, 0, 0.05)));
    run(w, 0.2);
    hash[k] = w.hash();
  }
  EXPECT_EQ(hash[0], hash[1]);
}

TEST(PartFilter, TheLastRuleAboutAContactDecides) {
  // All of the sheet is let through, but its east.
  World w(
      options({{"sheet", "ground", false}, {"sheet", "ground", true, [](const Vec3& x) { return x.x() > 0.0; }, {}}}));
  w.add(testing::ground(0.8));
  w.add(testing::sheet("sheet", 1.2, Vec3(0, 0, 0.1)));
  const std::vector<double> start(w.q(1).begin(), w.q(1).end());
  run(w, 0.25);
  const auto [cut, rest] = lowest_of(w, 1, start, 0.35);
  EXPECT_LT(cut, -0.1);
  EXPECT_GT(rest, -0.02);
}

TEST(PartFilter, OneThreadAndThreeGiveTheSameBits) {
  std::uint64_t hash[2];
  for (int k = 0; k < 2; ++k) {
    const ThreadLimit limit(k == 0 ? 1 : 3);
    WorldOptions o = options({apart("sheet", "jelly", west), apart("ball", "*", west)});
    World w(o);
    w.add(testing::ground(0.5));
    w.add(testing::jelly("jelly", 0.5, Vec3(-0.25, -0.25, 0.0)));
    w.add(testing::sheet("sheet", 0.8, Vec3(0, 0, 0.56)));
    w.add(testing::ball("ball", {Vec3(0.1, 0, 0.8)}, 0.5, 0.15, 300));
    run(w, 0.2);
    hash[k] = w.hash();
  }
  EXPECT_EQ(hash[0], hash[1]);
}

TEST(PartFilter, ARuleThatIsAddedIsPartOfTheState) {
  const auto world = [] {
    World w(options({}));
    w.add(testing::ground(0.8));
    w.add(testing::sheet("sheet", 1.2, Vec3(0, 0, 0.1)));
    w.set_touch(apart("sheet", "ground", west));
    return w;
  };
  World w = world();
  run(w, 0.1);
  const State middle = w.state();
  run(w, 0.1);
  World again = world();
  again.set_state(middle);
  run(again, 0.1);
  EXPECT_EQ(again.hash(), w.hash());
  // A state from before the rule undoes it.
  World plain(options({}));
  plain.add(testing::ground(0.8));
  plain.add(testing::sheet("sheet", 1.2, Vec3(0, 0, 0.1)));
  const State start = plain.state();
  run(plain, 0.2);
  w.set_state(start);
  run(w, 0.2);
  EXPECT_EQ(w.hash(), plain.hash());
}

TEST(PartFilter, FluidsPassThePartsOfSolidsThatTheyDoNotTouch) {
  World w(options({{"plate", "fluid", false, [](const Vec3& x) { return x.x() < 0.5; }, {}}}));
  w.add(testing::obstacle("plate", make_box(Vec3(2.0, 2.0, 0.2)), 0.5, Vec3(0, 0, -0.1)));
  w.add(testing::blob("fluid", 4, 0.1, Vec3(-0.6, -0.2, 0.05)));
  run(w, 0.5);
  EXPECT_LT(w.body(1).linear_momentum(w.v(1)).z() / w.body(1).mass(), -4.0) << "it falls freely";
}

TEST(PartFilter, WhatCarriesNoRegionIsRefused) {
  const auto pool = [] {
    GridFluidModel m;
    m.grid.n = {4, 4, 4}, m.grid.dx = 0.1;
    m.distance = [](const Vec3& x) { return x.z() - 0.25; };
    return testing::named<GridFluidBody>("fluid", m);
  };
  World w(options({}));
  w.add(testing::ground(0.5));
  w.add(pool());
  try {
    w.set_touch(apart("fluid", "ground", west));
    ADD_FAILURE() << "was taken";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("carries no region along"), std::string::npos) << e.what();
  }
  run(w, 0.1);
  World other(options({apart("fluid", "ground", west)}));
  other.add(pool());
  EXPECT_THROW(other.stiffness(), InputError);
  EXPECT_THROW(other.step(), InputError) << "it is not begun by half";
}

}  // namespace
}  // namespace brim::part_filter_test
