#include "brim/response/node_places.h"

#include <gtest/gtest.h>

#include <array>
#include <random>
#include <set>
#include <vector>

namespace brim::node_places_test {
namespace {

TEST(NodePlaces, FindsTheNodesWithinSoManyStepsOfAll) {
  const double h = 0.013;
  std::mt19937 rng(7);
  std::uniform_int_distribution<int> step(-6, 6);
  std::vector<Vec3> nodes;
  std::set<std::array<int, 3>> seen;
  while (nodes.size() < 150) {
    const std::array<int, 3> i = {step(rng), step(rng), step(rng)};
    if (seen.insert(i).second) nodes.push_back(h * Vec3(i[0], i[1], i[2]));
  }
  NodePlaces places;
  places.reset(h);
  for (std::size_t n = 0; n < nodes.size(); ++n) places.set(nodes[n], n);
  for (const int steps : {1, 2})
    for (const Vec3& at : nodes) {
      std::set<std::size_t> found, wanted;
      places.for_around(at, steps, [&](std::size_t n) { EXPECT_TRUE(found.insert(n).second); });
      for (std::size_t n = 0; n < nodes.size(); ++n)
        if ((nodes[n] - at).cwiseAbs().maxCoeff() < (steps + 0.5) * h) wanted.insert(n);
      EXPECT_EQ(found, wanted);
    }
}

TEST(NodePlaces, StopsAtTheFirstThatServesAndForgets) {
  NodePlaces places;
  places.reset(0.1);
  places.set(Vec3(0.1, 0, 0), 3);
  places.set(Vec3(-0.1, 0, 0), 4);
  int asked = 0;
  EXPECT_TRUE(places.any_around(Vec3::Zero(), 1, [&](std::size_t) { return ++asked > 0; }));
  EXPECT_EQ(asked, 1);
  EXPECT_FALSE(places.any_around(Vec3::Zero(), 1, [](std::size_t n) { return n == 5; }));
  places.reset(0.2);
  EXPECT_FALSE(places.any_around(Vec3::Zero(), 2, [](std::size_t) { return true; }));
}

}  // namespace
}  // namespace brim::node_places_test
