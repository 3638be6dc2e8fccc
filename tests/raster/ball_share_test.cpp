#include "brim/raster/ball_share.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "brim/math/ramp.h"
#include "brim/raster/shape.h"

namespace brim::ball_share_test {
namespace {

constexpr double kW = 3.0;

/// Share of a solid in the ball about p, counted on a lattice of 80 points to the diameter: within 0.004, or 0.007
/// where two flat faces lie along the lattice.
double counted(const Shape& shape, const Vec3& p) {
  const int n = 80;
  int inside = 0, all = 0;
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const Vec3 x = kW * ((Vec3(i, j, k) + Vec3::Constant(0.5)) / n - Vec3::Constant(0.5));
        if (x.norm() > 0.5 * kW) continue;
        ++all;
        inside += shape.distance(p + x) < 0.0;
      }
  return static_cast<double>(inside) / all;
}

/// Points of the octant x, y, z > 0 within a ball's reach of a surface.
std::vector<Vec3> near(const Shape& shape, int count) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const Vec3 hi = shape.bounds().hi + Vec3::Constant(kW);
  std::vector<Vec3> out;
  while (static_cast<int>(out.size()) < count) {
    const Vec3 p(unit(random) * hi.x(), unit(random) * hi.y(), unit(random) * hi.z());
    if (std::abs(shape.distance(p)) < 0.6 * kW) out.push_back(p);
  }
  return out;
}

TEST(BallShare, IsWhatIsCountedInTheBall) {
  for (const Vec3& p : near(*make_sphere(2.2), 30))
    EXPECT_NEAR(ball_share_of_sphere(p, kW, 2.2), counted(*make_sphere(2.2), p), 0.005) << p.transpose();
  for (const Vec3& p : near(*make_cylinder(2.2, 5.0), 30))
    EXPECT_NEAR(ball_share_of_cylinder(p, kW, 2.2, 2.5), counted(*make_cylinder(2.2, 5.0), p), 0.006) << p.transpose();
  for (const Vec3& p : near(*make_capsule(1.8, 4.0), 30))
    EXPECT_NEAR(ball_share_of_capsule(p, kW, 1.8, 2.0), counted(*make_capsule(1.8, 4.0), p), 0.006) << p.transpose();
  for (const Vec3& p : near(*make_torus(4.0, 1.8), 30))
    EXPECT_NEAR(ball_share_of_torus(p, kW, 4.0, 1.8), counted(*make_torus(4.0, 1.8), p), 0.006) << p.transpose();
  for (const Vec3& p : near(*make_bowl(5.0, 2.0), 30))
    EXPECT_NEAR(ball_share_of_bowl(p, kW, 4.0, 1.0), counted(*make_bowl(5.0, 2.0), p), 0.006) << p.transpose();
  for (const Vec3& p : near(*make_cup(4.0, 6.0, 1.5), 30))
    EXPECT_NEAR(ball_share_of_cup(p, kW, 4.0, 6.0, 1.5), counted(*make_cup(4.0, 6.0, 1.5), p), 0.008) << p.transpose();
  const Vec3 half(3.0, 2.5, 4.0);
  for (const Vec3& p : near(*make_box(2.0 * half), 60))
    EXPECT_NEAR(ball_share_of_box(p, kW, half), counted(*make_box(2.0 * half), p), 0.045) << p.transpose();
}

TEST(BallShare, WhatIsSmallerThanTheBallIsSeenInPart) {
  // By volumes: (0.5/1.5)³, and all of the ball in the large.
  EXPECT_NEAR(ball_share_of_sphere(Vec3(0.2, 0.1, 0), kW, 0.5), 1.0 / 27.0, 1e-12);
  EXPECT_EQ(ball_share_of_sphere(Vec3(0.2, 0.1, 0), kW, 5.0), 1.0);
  EXPECT_EQ(ball_share_of_sphere(Vec3(3.6, 0, 0), kW, 2.0), 0.0);
  EXPECT_NEAR(ball_share_of_capsule(Vec3::Zero(), kW, 0.3, 0.4), (0.09 * 0.8 + 4.0 / 3.0 * 0.027) / (4.0 / 3.0 * 3.375),
              2e-3);
}

TEST(BallShare, WhereASurfaceIsFlatItIsTheRamp) {
  for (double d = -1.6; d <= 1.6; d += 0.2) {
    EXPECT_NEAR(ball_share_of_box(Vec3(9.0 + d, 1.0, -2.0), kW, Vec3(9, 9, 9)), ramp(d, kW), 1e-12);
    EXPECT_NEAR(ball_share_of_cylinder(Vec3(1.0, -2.0, 9.0 + d), kW, 9.0, 9.0), ramp(d, kW), 1e-12);
  }
  EXPECT_NEAR(ball_share_of_box(Vec3(9, 9, 0), kW, Vec3(9, 9, 9)), 0.25, 1e-12);
  EXPECT_NEAR(ball_share_of_box(Vec3(9, 9, 9), kW, Vec3(9, 9, 9)), 0.125, 1e-12);
}

}  // namespace
}  // namespace brim::ball_share_test
