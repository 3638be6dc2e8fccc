#include "brim/math/box_sweep.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

namespace brim::box_sweep_test {
namespace {

std::set<std::pair<int, int>> pairs_of(const std::vector<Aabb>& boxes, std::span<const std::int32_t> group = {}) {
  BoxSweep sweep;
  sweep.build(boxes, group);
  std::set<std::pair<int, int>> found;
  std::vector<std::int32_t> partners;
  for (std::size_t i = 0; i < sweep.size(); ++i) {
    partners.clear();
    sweep.partners(i, partners);
    for (const std::int32_t j : partners) {
      const std::pair<int, int> pair(std::min(sweep.at(i), j), std::max(sweep.at(i), j));
      EXPECT_TRUE(found.insert(pair).second) << "found twice";
    }
  }
  return found;
}

std::set<std::pair<int, int>> every_pair(const std::vector<Aabb>& boxes) {
  std::set<std::pair<int, int>> found;
  for (int i = 0; i < static_cast<int>(boxes.size()); ++i)
    for (int j = i + 1; j < static_cast<int>(boxes.size()); ++j)
      if (boxes[i].overlaps(boxes[j])) found.insert({i, j});
  return found;
}

TEST(BoxSweep, FindsEachOverlappingPairOnce) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(0.0, 1.0), size(0.0, 0.1);
  for (const Vec3& extent : {Vec3(1, 1, 1), Vec3(0.1, 5, 0.1), Vec3(1, 1e-9, 1e4)}) {
    std::vector<Aabb> boxes;
    for (int i = 0; i < 333; ++i) {
      const Vec3 lo = Vec3(place(random), place(random), place(random)).cwiseProduct(extent);
      boxes.push_back({lo, lo + Vec3(size(random), size(random), size(random)).cwiseProduct(extent)});
    }
    const auto found = pairs_of(boxes);
    EXPECT_GT(found.size(), 20u);
    EXPECT_EQ(found, every_pair(boxes));
  }
}

TEST(BoxSweep, StartsFromItsLastOrder_AndEndsInThatOfANewOne) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(0.0, 1.0), step(-0.01, 0.01);
  std::vector<Aabb> boxes(500);
  for (Aabb& b : boxes) {
    b.lo = Vec3(place(random), place(random), 4.0 * place(random));
    b.hi = b.lo + Vec3::Constant(0.1);
  }
  BoxSweep kept;
  for (int time = 0; time < 40; ++time) {
    // They creep; once they are shuffled, another time their longest side turns, then there are fewer.
    for (Aabb& b : boxes) {
      const Vec3 by(step(random), step(random), step(random));
      b.lo += by, b.hi += by;
    }
    if (time == 10) std::shuffle(boxes.begin(), boxes.end(), random);
    if (time == 20)
      for (Aabb& b : boxes) std::swap(b.lo.x(), b.lo.z()), std::swap(b.hi.x(), b.hi.z());
    if (time == 30) boxes.resize(300);
    kept.build(boxes);
    BoxSweep fresh;
    fresh.build(boxes);
    for (std::size_t i = 0; i < boxes.size(); ++i) ASSERT_EQ(kept.at(i), fresh.at(i)) << time << ": " << i;
  }
}

TEST(BoxSweep, BoxesThatTouchByAFaceOverlapToTheLastBit) {
  // Numbers that single precision cannot tell apart.
  const double x = 1.0 + 1e-12;
  std::vector<Aabb> boxes;
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 shift = 10.0 * (axis + 1) * Vec3::Ones(), lo = Vec3::Zero(), apart = Vec3::Zero();
    lo[axis] = x, apart[axis] = x * (1.0 + 1e-15);
    boxes.push_back({shift, shift + Vec3::Ones() * x});
    boxes.push_back({shift + lo, shift + lo + Vec3::Ones()});
    boxes.push_back({shift + apart + 0.5 * Vec3::Ones() * 1e-13, shift + apart + Vec3::Ones()});
  }
  EXPECT_EQ(pairs_of(boxes), every_pair(boxes));
}

TEST(BoxSweep, UnboundedBoxesMeetAllAndWhatIsNoNumberMeetsNone) {
  const double infinity = std::numeric_limits<double>::infinity(), none = std::numeric_limits<double>::quiet_NaN();
  std::vector<Aabb> boxes = {{Vec3(0, 0, 0), Vec3(1, 1, 1)},
                             {Vec3(-infinity, -infinity, -infinity), Vec3(infinity, infinity, 0.5)},
                             {Vec3(none, none, none), Vec3(none, none, none)},
                             {Vec3(3, 3, 3), Vec3(4, 4, 4)},
                             {Vec3(0, none, 0), Vec3(9, 9, 9)},
                             Aabb{}};
  const std::set<std::pair<int, int>> expected = {{0, 1}};
  EXPECT_EQ(pairs_of(boxes), expected);
}

TEST(BoxSweep, BoxesOfOneGroupAreLeftAlone) {
  std::vector<Aabb> boxes(20, Aabb{Vec3::Zero(), Vec3::Ones()});
  std::vector<std::int32_t> group(20);
  for (std::int32_t i = 0; i < 20; ++i) group[i] = i % 3;
  const auto found = pairs_of(boxes, group);
  EXPECT_EQ(found.size(), 7u * 7u + 2u * 7u * 6u);
  for (const auto& [a, b] : found) EXPECT_NE(group[a], group[b]);
}

TEST(BoxSweep, NoBoxesHaveNoPairs) { EXPECT_TRUE(pairs_of({}).empty()); }

}  // namespace
}  // namespace brim::box_sweep_test
