#include "brim/world/edits.h"

#include <gtest/gtest.h>

#include <random>

namespace brim::edits_test {
namespace {

Edits some_edits() {
  Edits e;
  e.removed = {1, 4};
  e.frozen = {2};
  e.materials[3] = {"ice \xc3\xa9", 0.02, 0.3, Response::Constraint};
  e.materials[2] = {"tyre", 0.8, 0.0, Response::Inherit, 0.01};
  e.pairs[{"ice", "rubber"}] = {0.4, 2e5, -1.0, Response::Penalty};
  e.pairs[{"road", "tyre"}] = {0.9, 0.0, -1.0, Response::Inherit, 0.02};
  e.rules = {{{"a*", "b", true}}, {{"c", "*", false}, 2}};
  e.bases[4] = {Quat(Eigen::AngleAxisd(0.3, Vec3::UnitX())).toRotationMatrix(), Vec3(1, 2, 3)};
  e.gravity = Vec3(0, 0.1, -1.6);
  e.stiffness = 3e6;
  return e;
}

TEST(Edits, ComeBackFromMemoryAsTheyWereAndLeaveTheRestAlone) {
  std::vector<double> memory = {-0.5, 0.0, 7.0}, again;
  const std::vector<double> rest = memory;
  some_edits().keep(memory);
  Edits e;
  std::vector<double> taken = memory;
  e.take(taken, 5);
  EXPECT_EQ(taken, rest);
  again = rest;
  e.keep(again);
  EXPECT_EQ(again, memory);
  EXPECT_EQ(e.materials.at(3).name, "ice \xc3\xa9");
  EXPECT_EQ(e.materials.at(3).response, Response::Constraint);
  EXPECT_EQ(e.pairs.at({"ice", "rubber"}).stiffness, 2e5);
  EXPECT_EQ(e.materials.at(2).rolling_resistance, 0.01);
  EXPECT_EQ(e.materials.at(3).rolling_resistance, 0.0);
  EXPECT_EQ(e.pairs.at({"road", "tyre"}).rolling_resistance, 0.02);
  EXPECT_LT(e.pairs.at({"ice", "rubber"}).rolling_resistance, 0.0) << "not told";
  EXPECT_EQ(*e.gravity, Vec3(0, 0.1, -1.6));
  EXPECT_EQ(e.bases.at(4).translation, Vec3(1, 2, 3));
  EXPECT_EQ(e.bases.at(4).rotation, some_edits().bases.at(4).rotation);
  ASSERT_EQ(e.rules.size(), 2u);
  EXPECT_EQ(e.rules[0].region, -1);
  EXPECT_EQ(e.rules[1].region, 2);
  State s;
  s.warm_start = memory;
  EXPECT_EQ(removed_in(s), (std::vector<int>{1, 4}));
}

TEST(Edits, NothingIsKeptOfNothing) {
  std::vector<double> memory = {1.0, 2.0};
  Edits().keep(memory);
  EXPECT_EQ(memory, (std::vector<double>{1.0, 2.0}));
  EXPECT_TRUE(removed_in({}).empty());
}

TEST(Edits, DamagedMemoryGivesOnlyWhatMakesSense) {
  constexpr unsigned kSeed = 5;
  SCOPED_TRACE(kSeed);
  std::mt19937 random(kSeed);
  std::vector<double> good;
  some_edits().keep(good);
  const double wild[] = {std::nan(""), -1.0, 1e300, 0.5, 3.0, 255.0};
  for (int i = 0; i < 3000; ++i) {
    std::vector<double> memory = good;
    for (int k = 0; k < 3; ++k) memory[1 + random() % (memory.size() - 1)] = wild[random() % std::size(wild)];
    memory.resize(2 + random() % (memory.size() - 1));
    Edits e;
    e.take(memory, 5);
    for (const int b : e.removed) ASSERT_TRUE(b >= 0 && b < 5);
    for (const int b : e.frozen) ASSERT_TRUE(b >= 0 && b < 5);
    for (const auto& [b, m] : e.materials) {
      ASSERT_TRUE(b >= 0 && b < 5);
      ASSERT_TRUE(m.friction >= 0.0 && m.restitution >= 0.0 && m.restitution <= 1.0);
      ASSERT_TRUE(m.rolling_resistance >= 0.0 && std::isfinite(m.rolling_resistance));
    }
    for (const auto& [names, p] : e.pairs) ASSERT_TRUE(p.stiffness >= 0.0 && p.restitution <= 1.0);
    if (e.gravity) {
      ASSERT_TRUE(e.gravity->allFinite());
    }
  }
}

}  // namespace
}  // namespace brim::edits_test
