#include "brim/raster/averaged_solid.h"

#include <gtest/gtest.h>

#include <random>

#include "brim/math/ramp.h"

namespace brim::averaged_solid_test {
namespace {

constexpr double kStep = 0.05;

DistanceGrid ball(double radius) {
  const Aabb box = Aabb{Vec3::Constant(-radius), Vec3::Constant(radius)}.inflated(6 * kStep);
  return sample_distance(box, kStep, [=](const Vec3& p) { return p.norm() - radius; });
}

/// Share of a ball of diameter w about p that lies in the slab |z| < half: by sections.
double share_in_slab(double z, double half, double w) {
  const auto below = [&](double height) { return ramp(z - height, w); };  // of the half space z < height
  return below(half) - below(-half);
}

TEST(AveragedSolid, DensityIsTheShareOfMatterInABallAtAnyLevel) {
  // A slab of three cells, as a thin box: at 6, 12 and 24 cells of ramp its density is that of the slab, never full,
  // to what three cells to the radius and interpolation between them leave.
  const double half = 1.5 * kStep;
  const DistanceGrid grid = sample_distance({Vec3(-2, -2, -0.5), Vec3(2, 2, 0.5)}, kStep, [=](const Vec3& p) {
    return std::max({std::abs(p.x()) - 1.8, std::abs(p.y()) - 1.8, std::abs(p.z()) - half});
  });
  const OccupancyPyramid pyramid(occupancy_of(grid));
  for (const double w : {6 * kStep, 12 * kStep, 24 * kStep}) {
    const AveragedSolid solid(grid, pyramid.field(w));
    for (double z = -0.6 * w; z <= 0.6 * w; z += 0.1 * w)
      EXPECT_NEAR(ramp(solid.rough_distance({0.01, 0.02, z}), w), share_in_slab(z, half, w), 0.04) << w << " " << z;
  }
}

TEST(AveragedSolid, ALevelHasAnEighthOfTheCells) {
  const DistanceGrid grid = ball(2.0);
  const OccupancyPyramid pyramid(occupancy_of(grid));
  EXPECT_EQ(pyramid.level_of(6 * kStep), 0);
  EXPECT_EQ(pyramid.level_of(12 * kStep), 1);
  EXPECT_EQ(pyramid.level_of(23 * kStep), 1);
  EXPECT_EQ(pyramid.level_of(24 * kStep), 2);
  // Fields keep bricks along the surface only: a quarter of them.
  EXPECT_LT(2 * pyramid.field(24 * kStep).bytes(), pyramid.field(12 * kStep).bytes());
}

TEST(AveragedSolid, IsTheSameDistanceBeyondTheRampAndOffByLessThanItsSlack) {
  const DistanceGrid grid = ball(1.0);
  const OccupancyPyramid pyramid(occupancy_of(grid));
  const double w = 12 * kStep;
  const AveragedSolid solid(grid, pyramid.field(w));
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-1.6, 1.6);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p(place(random), place(random), place(random));
    const double d = p.norm() - 1.0;
    EXPECT_LE(std::abs(solid.rough_distance(p) - d), solid.slack());
    if (std::abs(grid.value(p, Interpolation::Trilinear)) > 0.5 * w + kStep) {
      EXPECT_EQ(solid.rough_distance(p), grid.value(p, Interpolation::Trilinear));
    }
    // Within the ramp the mean of a ball of radius 1 is about w²/40 inside of it (half its curvature times a mean
    // square).
    if (std::abs(d) < 0.2 * w) {
      EXPECT_NEAR(solid.rough_distance(p), d, 0.05 * w);
    }
  }
}

TEST(AveragedSolid, CubesHaveTheSameDistancesAsPoints) {
  const DistanceGrid grid = ball(1.0);
  const OccupancyPyramid pyramid(occupancy_of(grid));
  const AveragedSolid solid(grid, pyramid.field(12 * kStep));
  const Pose pose{Eigen::AngleAxisd(0.4, Vec3(1, 2, 3).normalized()).toRotationMatrix(), Vec3(0.1, -0.2, 0.3)};
  const NodeCube cube{Vec3i(6, -2, 1), 0.1};
  float d[kCubeNodes];
  solid.cube_distances(pose, cube, NodeMask::box(Vec3i::Zero(), Vec3i::Constant(7)), 1.0, d);
  for (int n = 0; n < kCubeNodes; ++n) {
    const Vec3 x = cube.origin() + cube.h * Vec3(n % 8, n / 8 % 8, n / 64);
    EXPECT_NEAR(d[n], solid.rough_distance(pose.to_local(x)), 1e-6);
  }
}

}  // namespace
}  // namespace brim::averaged_solid_test
