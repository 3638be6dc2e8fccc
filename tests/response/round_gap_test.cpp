#include "brim/response/round_gap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "brim/math/rotation.h"
#include "brim/mesh/distance_grid.h"
#include "brim/raster/grid_shape.h"
#include "contact/solid_side.h"

/// The least gap of sampled round solids, however they lie in the grid.
namespace brim::round_gap_test {
namespace {

constexpr double h = 0.1;

using testing::solid_side;

/// A solid over the plane z = 0, sampled half a voxel apart.
std::shared_ptr<const Shape> sampled(const Aabb& box, const std::function<double(const Vec3&)>& distance) {
  return make_grid_shape(std::make_shared<const DistanceGrid>(sample_distance(box, 0.5 * h, distance)), 1.0);
}

Pose any_pose(std::mt19937& rng) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  return {rotation_from_vector(Vec3(unit(rng), unit(rng), unit(rng))).toRotationMatrix(),
          Vec3(unit(rng), unit(rng), unit(rng))};
}

TEST(RoundGap, IsFoundOnASampledBallAndAlongASampledRoller) {
  constexpr unsigned kSeed = 3;
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const double radius = 5.0 * h, above = 0.02 * h;
  const Vec3 middle(0, 0, radius + above);
  const auto plane = make_half_space();
  const auto ball = sampled({Vec3(-0.7, -0.7, -0.2), Vec3(0.7, 0.7, 1.2)},
                            [&](const Vec3& p) { return (p - middle).norm() - radius; });
  const auto roller = sampled({Vec3(-0.7, -0.7, -0.2), Vec3(0.7, 0.7, 1.2)}, [&](const Vec3& p) {
    return std::hypot(p.x() - middle.x(), p.z() - middle.z()) - radius;
  });
  for (int trial = 0; trial < 50; ++trial) {
    const Pose world = any_pose(rng);
    const CubeSide b = solid_side(plane, world);
    const Vec3 start(0.7 * h * unit(rng), 0.7 * h * unit(rng), 0.3 * h * unit(rng));
    const Mat3 R = world.rotation, bend = R * Vec3(1.0 / radius, 1.0 / radius, 0.0).asDiagonal() * R.transpose(),
               bend_along = R * Vec3(1.0 / radius, 0.0, 0.0).asDiagonal() * R.transpose();
    const auto settled = [&](const std::shared_ptr<const Shape>& shape, const Mat3& curvature) {
      const CubeSide a = solid_side(shape, world);
      const Vec3 x = R * start + world.translation;
      const auto g = settle_round_gap(a, b, x, round_directions(a, b, x, R.col(2), curvature, h), h);
      EXPECT_TRUE(g);
      if (!g) return start;
      EXPECT_NEAR(g->gap, above, 2e-3 * h);
      return Vec3(R.transpose() * (g->x - world.translation));
    };
    const Vec3 on_ball = settled(ball, bend), on_roller = settled(roller, bend_along);
    EXPECT_LT(std::hypot(on_ball.x(), on_ball.y()), 0.02 * h);
    EXPECT_LT(std::abs(on_roller.x()), 0.02 * h);
    EXPECT_NEAR(on_roller.y(), start.y(), 1e-9) << "along the roller nothing is round";
  }
}

TEST(RoundGap, OfWhatIsFlatHollowOrSharpIsLeftAlone) {
  const auto plane = make_half_space();
  const auto hollow = sampled({Vec3(-0.7, -0.7, -0.7), Vec3(0.7, 0.7, 0.7)},
                              [](const Vec3& p) { return 0.5 - std::hypot(p.x(), p.z() - 0.5); });
  const auto ball = sampled({Vec3(-0.7, -0.7, -0.2), Vec3(0.7, 0.7, 1.2)},
                            [](const Vec3& p) { return (p - Vec3(0, 0, 0.5)).norm() - 0.5; });
  const Pose here{Mat3::Identity(), Vec3::Zero()};
  const CubeSide floor = solid_side(plane, here), bore = solid_side(hollow, here), above = solid_side(ball, here);
  const auto any = [&](const CubeSide& a, double bend) {
    const RoundDirections round = round_directions(a, floor, Vec3::Zero(), Vec3::UnitZ(), bend * Mat3::Identity(), h);
    return !round[0].isZero(0.0) || !round[1].isZero(0.0);
  };
  EXPECT_TRUE(any(above, 2.0));
  EXPECT_FALSE(any(above, 0.1)) << "nodes see a plane";
  EXPECT_FALSE(any(above, 12.0)) << "nodes see an edge";
  EXPECT_FALSE(any(floor, 2.0));
  EXPECT_FALSE(any(bore, 2.0));
  const auto roof = sampled({Vec3(-0.7, -0.7, -0.2), Vec3(0.7, 0.7, 1.2)},
                            [](const Vec3& p) { return std::abs(0.1 * p.x()) - std::sqrt(0.99) * p.z(); });
  EXPECT_FALSE(any(solid_side(roof, here), 2.0)) << "an edge between two faces";
  EXPECT_FALSE(settle_round_gap(floor, floor, Vec3::Zero(), {Vec3::UnitX(), Vec3::UnitY()}, h));
  EXPECT_FALSE(settle_round_gap(above, floor, Vec3::Zero(), {Vec3::Zero(), Vec3::Zero()}, h));
}

TEST(RoundGap, OfSurfacesWithFormulasIsExact) {
  constexpr unsigned kSeed = 7;
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  const auto ball = make_sphere(0.3), bowl = make_bowl(1.1, 0.1);
  for (int trial = 0; trial < 20; ++trial) {
    const Pose world = any_pose(rng);
    const Vec3 n = (Vec3(0, 0, 1.5) + any_pose(rng).translation).normalized();  // out of the bowl
    const CubeSide a = solid_side(ball, {world.rotation, world.rotation * (-0.7 * n) + world.translation}),
                   b = solid_side(bowl, world);
    const Vec3 up = world.rotation * n, x = world.translation - up;
    const Mat3 across = Mat3::Identity() - up * up.transpose();
    const Vec3 aside = 0.3 * h * any_pose(rng).translation;
    const auto seen = find_round_point(a, b, x + aside, (up + aside).normalized(), h);
    ASSERT_TRUE(seen);
    EXPECT_LT((seen->x - x).norm(), 1e-4 * h);
    EXPECT_NEAR(seen->gap, 0.0, 1e-5 * h);
    EXPECT_LT((seen->normal - up).norm(), 1e-4);
    EXPECT_LT((seen->bend_a - across / 0.3).norm(), 1e-2);
    EXPECT_LT((seen->bend_b + across).norm(), 1e-2) << "hollow";
  }
  const auto other = sampled({Vec3(-0.7, -0.7, -0.2), Vec3(0.7, 0.7, 1.2)},
                             [](const Vec3& p) { return (p - Vec3(0, 0, 0.5)).norm() - 0.5; });
  const Pose here{Mat3::Identity(), Vec3::Zero()};
  const CubeSide floor = solid_side(make_half_space(), here);
  const auto found = [&](const CubeSide& a) { return find_round_point(a, floor, Vec3::Zero(), Vec3::UnitZ(), h); };
  EXPECT_TRUE(found(solid_side(make_sphere(0.5), {Mat3::Identity(), Vec3(0, 0, 0.5)})));
  EXPECT_FALSE(found(solid_side(other, here))) << "sampled";
  EXPECT_FALSE(found(solid_side(make_capsule(0.5, 1.0),
                                {rotation_from_vector(Vec3(M_PI_2, 0, 0)).toRotationMatrix(), Vec3(0, 0, 0.5)})))
      << "a line";
  EXPECT_FALSE(found(solid_side(make_box(Vec3(1, 1, 1)), {Mat3::Identity(), Vec3(0, 0, 0.5)}))) << "a face";
  EXPECT_FALSE(found(solid_side(make_box(Vec3(1, 1, 1)), {rotation_from_vector(Vec3(M_PI_4, 0, 0)).toRotationMatrix(),
                                                          Vec3(0, 0, std::sqrt(0.5))})))
      << "an edge";
}

}  // namespace
}  // namespace brim::round_gap_test
