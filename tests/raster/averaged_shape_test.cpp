#include "brim/raster/averaged_shape.h"

#include <gtest/gtest.h>

#include <random>

namespace brim::averaged_shape_test {
namespace {

constexpr double kW = 0.3;

const KnownDistance& averaged(const Shape& shape) { return dynamic_cast<const AveragedDistances&>(shape).averaged(kW); }

std::vector<std::shared_ptr<const Shape>> shapes() {
  return {make_box(Vec3(1.0, 0.5, 0.8)), make_sphere(0.4), make_cylinder(0.3, 0.9), make_capsule(0.2, 0.6)};
}

TEST(AveragedShape, AnEdgeLiesFurtherInAndAFaceStays) {
  const auto box = make_box(Vec3(1, 1, 1));
  const KnownDistance& mean = averaged(*box);
  for (double d = -0.14; d < 0.14; d += 0.04) EXPECT_NEAR(mean.rough_distance(Vec3(0.5 + d, 0.1, 0)), d, 1e-9) << d;
  // A quarter and an eighth of the ball is matter: ramp_inverse of them.
  EXPECT_NEAR(mean.rough_distance(Vec3(0.5, 0.5, 0)), ramp_inverse(0.25, kW), 1e-12);
  EXPECT_NEAR(mean.rough_distance(Vec3(0.5, 0.5, 0.5)), ramp_inverse(0.125, kW), 1e-12);
}

TEST(AveragedShape, IsTheDistanceFarFromTheSurfaceAndNowhereLessThanItsLeast) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (const auto& shape : shapes()) {
    const KnownDistance& mean = averaged(*shape);
    for (int i = 0; i < 3000; ++i) {
      const Vec3 p(unit(random), unit(random), unit(random));
      const double d = shape->distance(p), m = mean.rough_distance(p);
      if (std::abs(d) > kW) {
        EXPECT_EQ(m, d);
      }
      EXPECT_GE(m, mean.least_distance(p)) << p.transpose();
      EXPECT_LE(std::abs(m - d), mean.slack()) << p.transpose();
    }
  }
}

TEST(AveragedShape, CubesHaveTheSameDistancesAsPoints) {
  const Pose pose{Eigen::AngleAxisd(0.4, Vec3(1, 2, 3).normalized()).toRotationMatrix(), Vec3(0.1, -0.2, 0.3)};
  const NodeCube cube{Vec3i(2, -2, 1), 0.1};
  for (const auto& shape : shapes()) {
    const KnownDistance& mean = averaged(*shape);
    float d[kCubeNodes];
    mean.cube_distances(pose, cube, NodeMask::box(Vec3i::Zero(), Vec3i::Constant(7)), 1.0, d);
    for (int k = 0; k < kCubeSize; ++k)
      for (int j = 0; j < kCubeSize; ++j)
        for (int i = 0; i < kCubeSize; ++i)
          EXPECT_NEAR(d[cube_index(i, j, k)],
                      mean.rough_distance(pose.to_local(cube.origin() + cube.h * Vec3(i, j, k))), 1e-6);
  }
}

}  // namespace
}  // namespace brim::averaged_shape_test
