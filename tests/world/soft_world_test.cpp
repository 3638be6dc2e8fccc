#include <gtest/gtest.h>

#include <set>

#include "brim/core/parallel.h"
#include "support/heap.h"
#include "support/soft_worlds.h"

/// Laws of a world as such, where bodies of several kinds touch: determinism, memory.
namespace brim::soft_world_test {
namespace {

/// Names of the bodies that touch in a step, "a-b".
std::set<std::string> touching(const World& w, const StepReport& r) {
  std::set<std::string> out;
  for (const PairReport& p : r.pairs)
    if (p.contacts > 0) out.insert(w.body(w.part(p.part_a).body).name() + "-" + w.body(w.part(p.part_b).body).name());
  return out;
}

TEST(SoftWorld, OneTwoOrFourThreadsGiveTheSameBitsAtEveryStep) {
  std::vector<std::uint64_t> one;
  std::set<std::string> met;
  for (const int threads : {1, 2, 4}) {
    const ThreadLimit limit(threads);
    World w = testing::soft_world_in_rain();
    for (int s = 0; s < 70; ++s) {
      const StepReport r = w.step();
      ASSERT_TRUE(r.ok);
      if (threads == 1) one.push_back(w.hash()), met.merge(touching(w, r));
      ASSERT_EQ(w.hash(), one[s]) << threads << " threads, step " << s;
    }
  }
  EXPECT_NE(one.front(), one.back());
  for (const char* pair : {"ground-jelly", "ground-springs", "jelly-sheet", "sheet-box", "springs-rope", "sheet-fluid",
                           "box-fluid", "rope-fluid"})
    EXPECT_TRUE(met.contains(pair)) << pair << " never touched";
}

TEST(SoftWorld, AThousandStepsOfElasticBodiesInContactTakeNoMoreMemory) {
  const ThreadLimit one(1);  // other threads have arenas of their own
  if (!testing::heap_is_measurable()) GTEST_SKIP() << "this allocator does not say what is in use";
  World w = testing::soft_world();
  // Arrays are enlarged when the pile slips as never before: that is seen in one window, a leak in every one.
  for (int s = 0; s < 700; ++s) w.step();
  std::size_t before = testing::bytes_in_use(), least = std::numeric_limits<std::size_t>::max();
  StepReport last;
  for (int window = 0; window < 3; ++window) {
    for (int s = 0; s < 500; ++s) last = w.step();
    const std::size_t now = testing::bytes_in_use();
    least = std::min(least, now > before ? now - before : 0);
    before = now;
  }
  EXPECT_LT(least, 2000u) << "a leak of one double a step would be 4 kB";
  for (const char* pair : {"ground-jelly", "ground-springs", "jelly-sheet", "sheet-box", "springs-rope"})
    EXPECT_TRUE(touching(w, last).contains(pair)) << pair << " do not touch";
}

}  // namespace
}  // namespace brim::soft_world_test
