#include "brim/contact/face_edges.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "brim/math/rotation.h"
#include "brim/mesh/distance_grid.h"
#include "brim/raster/grid_shape.h"
#include "brim/raster/shape.h"
#include "contact/solid_side.h"

/// Points of contact near the edge of a face go to the edge; those on curved surfaces and in a face's middle stay.
namespace brim::face_edges_test {
namespace {

constexpr double h = 0.1;

using testing::solid_side;

Vec3 carried_to_edge(const CubeSide& a, const CubeSide& b, Vec3 x, const Vec3& n, double step) {
  carry_to_edges(a, b, step, step, {&x, 1}, {&n, 1});
  return x;
}

TEST(FaceEdges, APointWithinAVoxelOfAnEdgeGoesThereToAFewHundredthsOfAVoxel) {
  const auto box = make_box(Vec3(1, 1, 1)), plane = make_half_space();
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> u(0.05, 0.95);
  for (int trial = 0; trial < 50; ++trial) {
    // The box stands on the plane, both turned together.
    const Pose world{rotation_from_vector(Vec3(u(rng), u(rng), u(rng))).toRotationMatrix(), Vec3(1, 2, 3)};
    const auto placed = [&](const Vec3& x) { return Vec3(world.rotation * x + world.translation); };
    const CubeSide a = solid_side(box, {world.rotation, placed(Vec3(0, 0, 0.5))}), b = solid_side(plane, world);
    const Vec3 n = world.rotation.col(2);
    const double s = u(rng) * h;
    // Straight towards it, from a place in the middle of the edge.
    const Vec3 y = world.rotation.transpose() *
                   (carried_to_edge(a, b, placed(Vec3(0.5 - s, 0.1, 0)), n, std::sqrt(2.0) * h) - world.translation);
    EXPECT_LE(y.x(), 0.5 + 0.03 * h);
    EXPECT_GE(y.x(), 0.5 - 0.06 * h);
    EXPECT_NEAR(y.z(), 0.0, 1e-12);
    const Vec3 middle = placed(Vec3(0.2, 0.1, 0));
    EXPECT_EQ(carried_to_edge(a, b, middle, n, h), middle);
  }
}

TEST(FaceEdges, OfASampledBoxPointsGoToItsEdgesAndCornersToATenthOfAVoxel) {
  const Vec3 half(0.5, 0.43, 0.37);
  const auto exact = [&](const Vec3& p) {
    const Vec3 q = p.cwiseAbs() - half;
    return q.cwiseMax(0.0).norm() + std::min(0.0, q.maxCoeff());
  };
  std::mt19937 rng(8);
  std::uniform_real_distribution<double> u(0.05, 0.95);
  const auto plane = make_half_space();
  for (int trial = 0; trial < 50; ++trial) {
    // The samples lie anywhere to the edges, a spacing of half a voxel apart.
    const Vec3 start = -half - 0.5 * h * Vec3(4 + u(rng), 4 + u(rng), 4 + u(rng));
    const auto box = make_grid_shape(
        std::make_shared<DistanceGrid>(sample_distance({start, half + Vec3::Constant(0.3)}, 0.5 * h, exact)), 0.7);
    const CubeSide a = solid_side(box, {Mat3::Identity(), Vec3(0, 0, half.z())}), b = solid_side(plane, {});
    // Nearer to the edge than half a voxel its samples have begun to rise: a point may stay there.
    const double s = (0.5 + 0.4 * u(rng)) * h, t = (0.5 + 0.4 * u(rng)) * h;
    const Vec3 edge = carried_to_edge(a, b, Vec3(half.x() - s, 0.1, 0), Vec3::UnitZ(), h),
               corner = carried_to_edge(a, b, Vec3(half.x() - s, half.y() - t, 0), Vec3::UnitZ(), h);
    EXPECT_NEAR(edge.x(), half.x(), 0.1 * h) << s / h;
    EXPECT_EQ(edge.y(), 0.1);
    EXPECT_NEAR(corner.x(), half.x(), 0.1 * h) << s / h;
    EXPECT_NEAR(corner.y(), half.y(), 0.1 * h) << t / h;
  }
}

TEST(FaceEdges, EdgesAslantToTheGridAreMetAtRightAngles) {
  const Vec3 half(0.5, 0.43, 0.37);
  const auto exact = [&](const Vec3& p) {
    const Vec3 q = p.cwiseAbs() - half;
    return q.cwiseMax(0.0).norm() + std::min(0.0, q.maxCoeff());
  };
  const auto sampled = make_grid_shape(std::make_shared<DistanceGrid>(sample_distance(
                                           {-half - Vec3::Constant(0.23), half + Vec3::Constant(0.3)}, 0.5 * h, exact)),
                                       0.7);
  const auto plane = make_half_space();
  std::mt19937 rng(10);
  std::uniform_real_distribution<double> u(0.1, 0.9);
  for (const auto& box : {make_box(2.0 * half), sampled})
    for (const double degrees : {20.0, 45.0, 70.0})
      for (int trial = 0; trial < 20; ++trial) {
        const Mat3 turn = rotation_from_vector(Vec3(0, 0, degrees * M_PI / 180)).toRotationMatrix();
        const CubeSide a = solid_side(box, {turn, Vec3(0, 0, half.z())}), b = solid_side(plane, {});
        const auto carried = [&](double x, double y) {
          return Vec3(turn.transpose() * carried_to_edge(a, b, turn * Vec3(x, y, 0), Vec3::UnitZ(), h));
        };
        const double s = u(rng) * h, t = (0.5 + 0.4 * u(rng)) * h;
        const Vec3 edge = carried(half.x() - s, 0.1), corner = carried(half.x() - s, half.y() - t);
        EXPECT_NEAR(edge.x(), half.x(), 0.05 * h) << degrees << " " << s / h;
        EXPECT_NEAR(edge.y(), 0.1, 0.01 * h) << degrees << " " << s / h;
        EXPECT_NEAR(corner.x(), half.x(), 0.1 * h) << degrees << " " << s / h << " " << t / h;
        EXPECT_NEAR(corner.y(), half.y(), 0.1 * h) << degrees << " " << s / h << " " << t / h;
      }
}

TEST(FaceEdges, PointsBesideTheEndOfACurvedContactMoveStraightToIt) {
  // A shaft on the inside of a tube, half as wide again: beside the line of contact the gap rises slowly.
  const auto tube =
      make_grid_shape(std::make_shared<DistanceGrid>(sample_distance(
                          {Vec3(-1.6, -1.6, -0.8), Vec3(1.6, 1.6, 0.8)}, 0.5 * h,
                          [](const Vec3& x) {
                            const double d = 1.2 - std::hypot(x.x(), x.y()), e = std::abs(x.z()) - 0.6;
                            return std::max(d, e) > 0.0 && d > 0.0 && e > 0.0 ? std::hypot(d, e) : std::max(d, e);
                          })),
                      1.0);
  const CubeSide a = solid_side(make_cylinder(1.16, 4.0), {Mat3::Identity(), Vec3(0.04, 0, 0)}),
                 b = solid_side(tube, {});
  for (const double turn : {0.0, 0.3, 0.8})
    for (const double below : {0.4, 0.7}) {
      const Vec3 n(-std::cos(turn), -std::sin(turn), 0.0), x = -1.2 * n + Vec3(0, 0, 0.6 - below * h);
      const Vec3 y = carried_to_edge(a, b, x, n, h);
      EXPECT_NEAR(y.z(), 0.6, 0.1 * h);
      EXPECT_LE(std::abs((y - x).dot(n.cross(Vec3::UnitZ()))), 0.05 * h) << turn << " " << below;
    }
}

TEST(FaceEdges, PointsOfABallAndOfARidgeStay) {
  const auto ball = make_sphere(0.4), box = make_box(Vec3(1, 1, 1)), plane = make_half_space();
  const CubeSide ground = solid_side(plane, {});
  for (const double x : {0.0, 0.3 * h, 1.2 * h}) {
    const Vec3 at(x, 0, 0);
    EXPECT_EQ(carried_to_edge(solid_side(ball, {Mat3::Identity(), Vec3(0, 0, 0.4)}), ground, at, Vec3::UnitZ(), h), at);
    // A box that stands on one of its edges, which lies along y.
    const Pose tilted{rotation_from_vector(Vec3(0, M_PI / 4, 0)).toRotationMatrix(), Vec3(0, 0, std::sqrt(0.5))};
    EXPECT_EQ(carried_to_edge(solid_side(box, tilted), ground, at, Vec3::UnitZ(), h), at);
  }
}

TEST(FaceEdges, ManyPointsGoWhereEachGoesAlone) {
  const auto box = make_box(Vec3(1, 1, 1)), plane = make_half_space();
  const CubeSide a = solid_side(box, {Mat3::Identity(), Vec3(0, 0, 0.5)}), b = solid_side(plane, {});
  std::mt19937 rng(9);
  std::uniform_real_distribution<double> u(-0.5, 0.5);
  std::vector<Vec3> points, normals(300, Vec3(0.01, 0.02, 1.0).normalized());
  for (std::size_t i = 0; i < normals.size(); ++i) points.emplace_back(u(rng), u(rng), 0.01 * u(rng));
  std::vector<Vec3> together = points;
  carry_to_edges(a, b, h, h, together, normals);
  int moved = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(together[i], carried_to_edge(a, b, points[i], normals[i], h));
    moved += together[i] != points[i];
  }
  EXPECT_GT(moved, 30);
  EXPECT_LT(moved, 200);
}

TEST(FaceEdges, BetweenTwoEdgesAPointGoesToTheMiddle) {
  const auto blade = make_box(Vec3(1.3 * h, 1, 1)), plane = make_half_space();
  const Vec3 y = carried_to_edge(solid_side(blade, {Mat3::Identity(), Vec3(0, 0, 0.5)}), solid_side(plane, {}),
                                 Vec3(0.1 * h, 0, 0), Vec3::UnitZ(), h);
  EXPECT_NEAR(y.x(), 0.0, 0.05 * h);
}

}  // namespace
}  // namespace brim::face_edges_test
