#include "brim/mesh/convex_gap.h"

#include <gtest/gtest.h>

#include <limits>

#include "brim/mesh/ray.h"
#include "mesh/data.h"

namespace brim::convex_gap_test {
namespace {

const Aabb kUnit{Vec3::Constant(-1), Vec3::Constant(1)};

auto box_of(const Vec3& center, const Vec3& half) {
  return [=](const Vec3& d) -> Vec3 {
    return center + half.cwiseProduct(d.unaryExpr([](double x) { return x < 0.0 ? -1.0 : 1.0; }));
  };
}

auto ball_of(const Vec3& center, double radius) {
  return [=](const Vec3& d) -> Vec3 { return center + radius * d.normalized(); };
}

/// Whether two sets are as far apart as said, to 1e-6.
template <class A, class B>
void expect_gap(const A& a, const B& b, double gap) {
  EXPECT_TRUE(within_reach(a, b, gap + 1e-6)) << gap;
  EXPECT_FALSE(within_reach(a, b, gap - 1e-6)) << gap;
}

TEST(ConvexGap, OfBoxesAndBallsIsThatByHand) {
  const Vec3 half(1, 0.5, 0.25);
  expect_gap(box_of(Vec3::Zero(), half), box_of(Vec3(5, 0, 0), half), 3.0);
  expect_gap(box_of(Vec3::Zero(), half), box_of(Vec3(5, 5, 0), half), 5.0);
  EXPECT_TRUE(within_reach(box_of(Vec3::Zero(), half), box_of(Vec3(1.9, 0.2, 0.1), half), 0.0));
  expect_gap(ball_of(Vec3::Zero(), 0.5), ball_of(Vec3(1, 2, 2), 1.0), 1.5);
  EXPECT_TRUE(within_reach(ball_of(Vec3::Zero(), 0.5), ball_of(Vec3(0.1, 0.2, 0.2), 1.0), 0.0));
  const auto point = [](const Vec3&) -> Vec3 { return Vec3(1, 2, 3); };
  EXPECT_TRUE(within_reach(point, point, 0.0)) << "two equal points";
}

TEST(ConvexGap, OfRandomBallsAndBoxesIsTheDistanceOfTheCentre) {
  const std::uint64_t seed = 21;
  SCOPED_TRACE(seed);
  test::Random random(seed);
  int apart = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 c = 2.0 * random.in(kUnit), half = random.in(kUnit).cwiseAbs() + Vec3::Constant(0.05);
    const double r = random(0.05, 0.8);
    const double gap = (c.cwiseAbs() - half).cwiseMax(0.0).norm() - r;
    const auto ball = ball_of(c, r);
    const auto box = box_of(Vec3::Zero(), half);
    if (gap > 1e-5) {
      ++apart;
      EXPECT_FALSE(within_reach(ball, box, 0.0)) << i;
      expect_gap(ball, box, gap);
    } else if (gap < -1e-5) {
      EXPECT_TRUE(within_reach(ball, box, 0.0)) << i;
    }
  }
  EXPECT_GT(apart, 400);
}

TEST(ConvexGap, IsNotBeatenByAnySampleOfTwoTriangles) {
  const std::uint64_t seed = 22;
  SCOPED_TRACE(seed);
  test::Random random(seed);
  const auto sample = [&](const RoundedSimplex& s) -> Vec3 {
    double u = random(0, 1), v = random(0, 1);
    if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
    return s.corner[0] + u * (s.corner[1] - s.corner[0]) + v * (s.corner[2] - s.corner[0]);
  };
  for (int i = 0; i < 300; ++i) {
    RoundedSimplex a{{random.in(kUnit), random.in(kUnit), random.in(kUnit)}, 3, 0.0}, b = a;
    const Vec3 aside(random(0, 2), 0, 0);
    for (Vec3& x : b.corner) x = random.in(kUnit) + aside;
    double least = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3000; ++k) least = std::min(least, (sample(a) - sample(b)).norm());
    const auto of_a = [&](const Vec3& d) { return a.support(d); };
    const auto of_b = [&](const Vec3& d) { return b.support(d); };
    EXPECT_TRUE(within_reach(of_a, of_b, least)) << i;
    // As near as 3000 samples come.
    if (least > 0.3) {
      EXPECT_FALSE(within_reach(of_a, of_b, least - 0.3)) << i;
    }
  }
}

}  // namespace
}  // namespace brim::convex_gap_test
