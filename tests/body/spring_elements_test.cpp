#include "brim/body/particles/spring_elements.h"

#include <gtest/gtest.h>

#include <cmath>

namespace brim::spring_elements_test {
namespace {

const std::vector<double> kLine = {0, 0, 0, 2, 0, 0};

SpringElements spring(bool slack, double length = 2.0) {
  const std::vector<Vec3> x = {Vec3(0, 0, 0), Vec3(2, 0, 0)};
  return SpringElements(std::vector<Spring>{{{0, 1}, 50.0, length}}, x, slack);
}

TEST(SpringsThatTurn, AreLongerByTheirWayAcross) {
  // Along by 0.1, across by 0.6: the solve knows of a length of 2.1, and it is √(2.1² + 0.6²).
  const std::vector<double> way = {0, 0, 0, 0.1, 0.6, 0}, none(6, 0.0);
  std::vector<double> force(6, 0.0);
  const double longer = std::hypot(2.1, 0.6) - 2.1;
  EXPECT_NEAR(spring(false).add_turned(kLine, way, none, force), 0.5 * 50.0 * longer * longer, 1e-12);
  EXPECT_NEAR(force[0], 50.0 * longer, 1e-12);
  EXPECT_NEAR(force[3], -50.0 * longer, 1e-12);
  EXPECT_EQ(force[1], 0.0);
  // What has been set right asks for no more.
  const std::vector<double> back = {0, 0, 0, std::sqrt(2.1 * 2.1 - 0.36) - 2.1, 0, 0};
  EXPECT_NEAR(spring(false).add_turned(kLine, way, back, force), 0.0, 1e-12);
}

TEST(SpringsThatTurn, DoNotCountWhereStringsAreSlackOrTurnedTooFar) {
  const std::vector<double> across = {0, 0, 0, 0, 0.6, 0}, far = {0, 0, 0, -1.5, 2, 0}, none(6, 0.0);
  std::vector<double> force(6, 0.0);
  EXPECT_EQ(spring(true, 2.5).add_turned(kLine, across, none, force), 0.0);
  EXPECT_EQ(spring(false).add_turned(kLine, far, none, force), 0.0);
  EXPECT_EQ(force, none);
  // A string that turning would tighten counts from its length on.
  const double longer = std::hypot(2.0, 0.6) - 2.05;
  EXPECT_NEAR(spring(true, 2.05).add_turned(kLine, across, none, force), 0.5 * 50.0 * longer * longer, 1e-12);
}

}  // namespace
}  // namespace brim::spring_elements_test
