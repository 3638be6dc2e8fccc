#include "brim/world/touch_rules.h"

#include <gtest/gtest.h>

#include <random>

#include "brim/core/error.h"
#include "support/worlds.h"

namespace brim {
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

TEST(TouchRules, MoreThanSixtyFourAreRefused) {
  TouchRules rules;
  for (std::size_t i = 0; i < TouchRules::kMost; ++i) rules.add({"a", "b"});
  EXPECT_THROW(rules.add({"a", "b"}), InputError);
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
}  // namespace brim
