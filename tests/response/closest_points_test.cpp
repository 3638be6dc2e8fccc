#include "brim/response/closest_points.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>

#include "brim/raster/known_distance.h"

namespace brim::closest_points_test {
namespace {

PlacedConvex placed(const std::shared_ptr<const Shape>& shape, const Pose& pose) {
  return {dynamic_cast<const KnownDistance&>(*shape).convex(), pose};
}

struct Random {
  std::mt19937 engine{23};
  Vec3 vector() {
    std::normal_distribution<double> n;
    const double x = n(engine), y = n(engine);
    return {x, y, n(engine)};
  }
  Mat3 turn() {
    std::normal_distribution<double> n;
    return Eigen::Quaterniond(n(engine), n(engine), n(engine), n(engine)).normalized().toRotationMatrix();
  }
};

TEST(ClosestPoints, LieOnBothSolidsAndNoPlaceIsCloserToBoth) {
  Random random;
  const std::shared_ptr<const Shape> shapes[] = {make_box(Vec3(2.0, 0.3, 0.01)), make_capsule(0.02, 1.5),
                                                 make_cylinder(0.8, 0.02), make_sphere(0.4), make_box(Vec3(1, 1, 1))};
  int apart = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const auto &a = shapes[trial % 5], &b = shapes[trial / 5 % 5];
    const Pose pose_a{random.turn(), random.vector()}, pose_b{random.turn(), Vec3::Zero()};
    Vec3 x, y;
    if (!closest_points(placed(a, pose_a), placed(b, pose_b), pose_a.translation, 1e-7, x, y)) continue;
    ++apart;
    const double gap = (x - y).norm();
    EXPECT_NEAR(a->distance(pose_a.to_local(x)), 0.0, 1e-5);
    EXPECT_NEAR(b->distance(pose_b.to_local(y)), 0.0, 1e-5);
    // At the closest points the distances to the other solids are the gap.
    EXPECT_NEAR(b->distance(pose_b.to_local(x)), gap, 1e-5);
    EXPECT_NEAR(a->distance(pose_a.to_local(y)), gap, 1e-5);
  }
  EXPECT_GT(apart, 100);
}

TEST(ClosestPoints, AreNotThereWhereSolidsOverlapOrHaveNoEnd) {
  Vec3 x, y;
  const auto box = make_box(Vec3(1, 1, 1)), plane = make_half_space();
  EXPECT_FALSE(
      closest_points(placed(box, {}), placed(box, {Mat3::Identity(), Vec3(0.5, 0.3, 0.2)}), Vec3::UnitX(), 1e-6, x, y));
  EXPECT_FALSE(
      closest_points(placed(box, {Mat3::Identity(), Vec3(0, 0, 2)}), placed(plane, {}), Vec3::UnitZ(), 1e-6, x, y));
  ASSERT_TRUE(
      closest_points(placed(box, {Mat3::Identity(), Vec3(0, 0, 3)}), placed(box, {}), Vec3::UnitZ(), 1e-6, x, y));
  EXPECT_NEAR((x - y).norm(), 2.0, 1e-6);
}

}  // namespace
}  // namespace brim::closest_points_test
