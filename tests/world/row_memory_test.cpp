#include "brim/world/row_memory.h"

#include <gtest/gtest.h>

namespace brim::row_memory_test {
namespace {

TEST(RowMemory, PointsFindTheNearestOfTheirPairOnceAndWithinTwoVoxels) {
  std::vector<double> memory;
  ContactPair first, second, third;
  first.part_a = 0, first.part_b = 3;
  second.part_a = 1, second.part_b = 2;
  third.part_a = 1, third.part_b = 4;
  RowMemory::keep(first, Vec3(0, 0, 0), Vec3(1, 0, 0), memory);
  RowMemory::keep(second, Vec3(1, 0, 0), Vec3(0, 2, 0), memory);
  RowMemory::keep(second, Vec3(1.1, 0, 0), Vec3(0, 3, 0), memory);
  RowMemory::keep(third, Vec3(1, 0, 0), Vec3(0, 0, 4), memory);

  ContactSet points;
  second.h = third.h = 0.1;
  second.begin = 0, second.end = 3;
  third.begin = 3, third.end = 4;
  points.pairs = {second, third};
  points.resize(4);
  points.point = {Vec3(1.09, 0, 0), Vec3(1.08, 0, 0), Vec3(1.05, 0, 0), Vec3(1.3, 0, 0)};
  std::vector<Vec3> force(4, Vec3::Ones());
  RowMemory recall;
  recall.recall(memory, points, force);
  EXPECT_EQ(force[0], Vec3(0, 3, 0));  // the nearer of the two
  EXPECT_EQ(force[1], Vec3(0, 2, 0));  // what is left
  EXPECT_EQ(force[2], Vec3::Zero());   // both are taken
  EXPECT_EQ(force[3], Vec3(0, 0, 4));  // three voxels away, but nothing else takes it
}

TEST(RowMemory, WhereAllPointsOfAPairAreOthersTheyShareItsForce) {
  std::vector<double> memory;
  ContactPair pair;
  pair.part_a = 0, pair.part_b = 1, pair.h = 0.1, pair.begin = 0, pair.end = 2;
  for (const double x : {0.0, 1.0, 2.0}) RowMemory::keep(pair, Vec3(x, 0, 0), Vec3(1, 0, x), memory);
  ContactSet points;
  points.pairs = {pair};
  points.resize(2);
  points.point = {Vec3(0.5, 0, 0), Vec3(5, 0, 0)};
  std::vector<Vec3> force(2);
  RowMemory recall;
  recall.recall(memory, points, force);
  EXPECT_TRUE(recall.shared(0));
  for (const Vec3& f : force) EXPECT_EQ(f, Vec3(1.5, 0, 1.5));
  points.point[0] = Vec3(0.05, 0, 0);  // one is known
  recall.recall(memory, points, force);
  EXPECT_FALSE(recall.shared(0));
  EXPECT_EQ(force[0], Vec3(1, 0, 0));
  EXPECT_EQ(force[1], Vec3::Zero());
}

TEST(RowMemory, TellsThePairsThatHavePoints) {
  std::vector<double> memory;
  EXPECT_TRUE(RowMemory::pairs(memory).empty());
  ContactPair first, second;
  first.part_a = 0, first.part_b = 3;
  second.part_a = 1, second.part_b = 2;
  RowMemory::keep(first, Vec3::Zero(), Vec3::Zero(), memory);
  RowMemory::keep(second, Vec3::Zero(), Vec3::Zero(), memory);
  RowMemory::keep(second, Vec3::Ones(), Vec3::Zero(), memory);
  const std::vector<std::pair<std::int32_t, std::int32_t>> expected = {{0, 3}, {1, 2}};
  EXPECT_EQ(RowMemory::pairs(memory), expected);
}

}  // namespace
}  // namespace brim::row_memory_test
