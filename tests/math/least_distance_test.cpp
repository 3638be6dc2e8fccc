#include "brim/math/least_distance.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

namespace brim::least_distance_test {
namespace {

using Corners = std::array<Vec3, 3>;

const Corners kFlat = {Vec3(0.0, 0.0, 0.0), Vec3(2.0, 0.0, 0.0), Vec3(0.0, 2.0, 0.0)};

TEST(LeastDistance, IsTheDistanceOfACornerAndAFace) {
  const Corners above = {Vec3(0.5, 0.5, 0.7), Vec3(0.5, 0.6, 2.0), Vec3(0.7, 0.5, 3.0)};
  EXPECT_NEAR(least_distance(kFlat, above), 0.7, 1e-12);
}

TEST(LeastDistance, IsTheDistanceOfTwoEdges) {
  const std::array<Vec3, 2> a = {Vec3(-1.0, 0.0, 0.0), Vec3(1.0, 0.0, 0.0)},
                            b = {Vec3(0.3, -1.0, 0.4), Vec3(0.3, 1.0, 0.4)};
  EXPECT_NEAR(least_distance(a, b), 0.4, 1e-12);
}

TEST(LeastDistance, IsTheDistanceOfTwoCorners) {
  const std::array<Vec3, 2> beyond = {Vec3(-3.0, -4.0, 0.0), Vec3(-6.0, -8.0, 1.0)};
  EXPECT_NEAR(least_distance(kFlat, beyond), 5.0, 1e-12);
}

TEST(LeastDistance, IsZeroWhereTheyIntersectAndOfPoints) {
  const Corners through = {Vec3(0.5, 0.5, -1.0), Vec3(0.5, 0.5, 1.0), Vec3(3.0, 3.0, 0.0)};
  EXPECT_EQ(least_distance(kFlat, through), 0.0);
  const Corners degenerate = {kFlat[0], kFlat[0], kFlat[0]};
  EXPECT_EQ(least_distance(kFlat, degenerate), 0.0);
}

TEST(LeastDistance, IsNeverMoreThanTheWayBetweenAnyTwoPoints) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto point = [&] {
    const double x = unit(random), y = unit(random), z = unit(random);
    return Vec3(x, y, z);
  };
  int apart = 0;
  for (int n = 0; n < 2000; ++n) {
    const Vec3 shift = 1.5 * point();
    const Corners a = {point(), point(), point()}, b = {point() + shift, point() + shift, point() + shift};
    const double bound = least_distance(a, b);
    constexpr int kSteps = 12;
    double least = 1e9;
    for (int i = 0; i <= kSteps; ++i)
      for (int j = 0; i + j <= kSteps; ++j)
        for (int k = 0; k <= kSteps; ++k)
          for (int l = 0; k + l <= kSteps; ++l) {
            const Vec3 on_a = a[0] + (i * (a[1] - a[0]) + j * (a[2] - a[0])) / kSteps;
            const Vec3 on_b = b[0] + (k * (b[1] - b[0]) + l * (b[2] - b[0])) / kSteps;
            least = std::min(least, (on_a - on_b).norm());
          }
    ASSERT_LE(bound, least + 1e-12) << n;
    // Points are up to a twelfth of an edge from the nearest ones; a corner nearest to an edge is not exact.
    if (!(bound > 0.0)) continue;
    ++apart;
    EXPECT_GT(bound, 0.6 * (least - 0.2)) << n;
  }
  EXPECT_GT(apart, 500);
}

}  // namespace
}  // namespace brim::least_distance_test
