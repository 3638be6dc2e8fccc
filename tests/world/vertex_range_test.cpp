#include "brim/world/vertex_range.h"

#include <gtest/gtest.h>

#include <random>

namespace brim::vertex_range_test {
namespace {

TEST(VertexRange, IsTheLeastAndTheLargestOfAllPoints) {
  const unsigned seed = 5;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  for (const std::size_t n : {1u, 3u, 8u, 9u, 257u}) {
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < n; ++i)
      points.push_back(Vec3(5.0, -2.0, 0.5) + Vec3(number(random), number(random), number(random)));
    const VertexRange range(points);
    Vec3 mean = Vec3::Zero();
    for (const Vec3& p : points) mean += p / static_cast<double>(n);
    EXPECT_LT((range.mean() - mean).norm(), 1e-14);
    for (int k = 0; k < 20; ++k) {
      const Vec3 a = Vec3(number(random), number(random), number(random)).normalized();
      double least = 1e9, largest = -1e9;
      for (const Vec3& p : points) least = std::min(least, a.dot(p)), largest = std::max(largest, a.dot(p));
      const auto [low, high] = range.along(a);
      // Points lie within 2 of their mean: a few roundings of single precision.
      EXPECT_NEAR(low, least, 1e-6) << n;
      EXPECT_NEAR(high, largest, 1e-6) << n;
    }
  }
}

TEST(VertexRange, EqualListsShareOne) {
  const std::vector<Vec3> a = {Vec3(0, 0, 0), Vec3(1, 2, 3)}, b = a, c = {Vec3(0, 0, 0), Vec3(1, 2, 4)};
  VertexRanges ranges;
  EXPECT_EQ(ranges.of(a), ranges.of(b));
  EXPECT_NE(ranges.of(a), ranges.of(c));
  EXPECT_TRUE(VertexRange(std::vector<Vec3>{}).empty());
}

}  // namespace
}  // namespace brim::vertex_range_test
