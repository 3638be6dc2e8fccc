#include "brim/world/touch_rules.h"

#include <gtest/gtest.h>

#include <bit>
#include <functional>
#include <random>

#include "brim/core/error.h"
#include "support/worlds.h"

namespace brim::touch_rules_test {
namespace {

TEST(TouchRules, ANameIsMatchedByItselfItsStemAndPatterns) {
  EXPECT_TRUE(name_matches("box", "box"));
  EXPECT_TRUE(name_matches("box", "box.12"));
  EXPECT_FALSE(name_matches("box", "box.lid"));
  EXPECT_FALSE(name_matches("box", "boxes"));
  EXPECT_TRUE(name_matches("b*x", "box"));
  EXPECT_TRUE(name_matches("*", ""));
  EXPECT_TRUE(name_matches("a*b*c", "aXbXbXc"));
  EXPECT_FALSE(name_matches("a*b*c", "aXcXb"));
  EXPECT_TRUE(name_matches("bo?", "box"));
  EXPECT_FALSE(name_matches("bo?", "bo"));
}

TEST(TouchRules, TheLastRuleAboutAPairDecidesAsALoopOverAllWouldSay) {
  std::mt19937 random(3);
  const std::vector<std::string> names = {"a", "b", "c.1", "c.2", "d"}, words = {"a", "b", "c", "c.2", "*", "d"};
  for (int trial = 0; trial < 200; ++trial) {
    TouchRules rules;
    std::vector<TouchRule> list;
    for (int i = 0; i < 8; ++i) {
      list.push_back({words[random() % words.size()], words[random() % words.size()], random() % 2 == 0});
      rules.add(list.back());
    }
    for (const std::string& x : names)
      for (const std::string& y : names) {
        bool touch = true;
        for (const TouchRule& r : list)
          if ((name_matches(r.a, x) && name_matches(r.b, y)) || (name_matches(r.a, y) && name_matches(r.b, x)))
            touch = r.touch;
        EXPECT_EQ(rules.touch(rules.sides(x), 0, rules.sides(y), 1), touch) << "trial " << trial << " " << x << y;
      }
  }
}

TEST(TouchRules, OfRulesAboutPartsTheLastOneAboutAContactDecides) {
  std::mt19937 random(4);
  const std::vector<std::string> names = {"a", "b", "c.1"}, words = {"a", "b", "c", "*"};
  const auto west = [](const Vec3& x) { return x.x() < 0.0; };
  const auto low = [](const Vec3& x) { return x.z() < 0.0; };
  for (int trial = 0; trial < 300; ++trial) {
    TouchRules rules;
    std::vector<TouchRule> list;
    for (int i = 0; i < 6; ++i) {
      TouchRule r{words[random() % words.size()], words[random() % words.size()], random() % 2 == 0};
      if (random() % 2 == 0) r.region_a = west;
      if (random() % 3 == 0) r.region_b = low;
      list.push_back(r);
      rules.add(r, i);
    }
    for (const std::string& x : names)
      for (const std::string& y : names) {
        const TouchRules::Sides sx = rules.sides(x), sy = rules.sides(y);
        bool any = false;
        for (const double east : {-1.0, 1.0})
          for (const double up : {-1.0, 1.0}) {
            const Vec3 at(east, 0, up);
            const auto lies = [&](const std::function<bool(const Vec3&)>& region) { return !region || region(at); };
            bool touch = true;
            for (const TouchRule& r : list)
              if (lies(r.region_a) && lies(r.region_b) &&
                  ((name_matches(r.a, x) && name_matches(r.b, y)) || (name_matches(r.a, y) && name_matches(r.b, x))))
                touch = r.touch;
            const bool found = rules.touch_there(sx, sy, [&](int i, bool) {
              return lies(list[static_cast<std::size_t>(i)].region_a) &&
                     lies(list[static_cast<std::size_t>(i)].region_b);
            });
            EXPECT_EQ(found, touch) << "trial " << trial << " " << x << y;
            any = any || touch;
            if (rules.about_parts(sx, sy) == 0) {
              EXPECT_EQ(rules.touch(sx, 0, sy, 1), touch) << "trial " << trial << " " << x << y;
            }
          }
        // A pair of which some contact may touch is looked at.
        if (any) {
          EXPECT_TRUE(rules.touch(sx, 0, sy, 1)) << "trial " << trial << " " << x << y;
        }
      }
  }
}

TEST(TouchRules, MoreThanSixtyFourOfDifferentNamesAreRefused) {
  TouchRules rules;
  for (std::size_t i = 0; i < TouchRules::kMost; ++i) rules.add({"a", "b" + std::to_string(i)});
  EXPECT_THROW(rules.add({"a", "b"}), InputError);
  EXPECT_NO_THROW(rules.add({"b7", "a", true}));
  EXPECT_TRUE(rules.touch(rules.sides("a"), 0, rules.sides("b7"), 1));
  EXPECT_FALSE(rules.touch(rules.sides("a"), 0, rules.sides("b8"), 1));
}

TEST(TouchRules, AllOfAPairReplacesWhatWasSaidOfItsPartsAndPartsDoNot) {
  TouchRules rules;
  const auto region = [](const Vec3& x) { return x.z() > 0.0; };
  const auto about = [&] { return rules.about_parts(rules.sides("a"), rules.sides("b")); };
  rules.add({"a", "b", true});
  rules.add({"a", "b", false, region}, 0);
  rules.add({"b", "a", false, {}, region}, 1);
  EXPECT_EQ(std::popcount(about()), 2);
  EXPECT_TRUE(rules.touch_there(rules.sides("a"), rules.sides("b"), [](int, bool) { return false; }));
  rules.add({"b", "a", false});
  EXPECT_EQ(about(), 0u);
  EXPECT_FALSE(rules.touch(rules.sides("a"), 0, rules.sides("b"), 1));
}

TEST(TouchRules, APairIsToggledAsOftenAsOneLikes) {
  for (const bool begun : {false, true}) {
    World w(testing::options_at(0.1));
    w.add(testing::ground(0.5));
    w.add(testing::box("box", {Vec3(0, 0, 0.6)}));
    if (begun) w.step();
    for (int i = 0; i < 300; ++i) w.set_touch({"box", "ground", i % 2 == 1});
    const std::size_t memory = w.state().warm_start.size();
    for (int i = 0; i < 300; ++i) w.set_touch({"ground", "box", i % 2 == 1});
    EXPECT_EQ(w.state().warm_start.size(), memory);
    EXPECT_EQ(w.options().touch_rules.size(), 1u);
    for (int s = 0; s < 60; ++s) w.step();
    EXPECT_GT(testing::position(w, 1).z(), 0.4);
  }
}

TEST(TouchRules, ABoxFallsThroughTheGroundThatItDoesNotTouchUntilItIsToldTo) {
  using namespace testing;
  WorldOptions o = options_at(0.125);
  o.touch_rules = {{"b*", "ground", false}};
  World w(o);
  w.add(ground(0.5));
  w.add(box("box", {Vec3(0, 0, 0.5)}));
  w.add(box("other", {Vec3(3, 0, 0.5)}));
  run(w, 0.2);
  EXPECT_NEAR(position(w, 1).z(), 0.5 - 0.5 * 9.81 * 0.04, 0.03);
  EXPECT_NEAR(position(w, 2).z(), 0.5, 0.01);
  w.set_touch({"*", "ground", true});
  EXPECT_GT(w.step().contacts, 0);
  double lowest = position(w, 1).z();
  for (int s = 0; s < 30; ++s) w.step(), lowest = std::min(lowest, position(w, 1).z());
  EXPECT_GT(lowest, 0.1);
}

}  // namespace
}  // namespace brim::touch_rules_test
