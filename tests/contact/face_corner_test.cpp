#include "brim/contact/face_corner.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "brim/math/rotation.h"
#include "brim/mesh/distance_grid.h"
#include "brim/raster/grid_shape.h"
#include "contact/solid_side.h"

/// Corners of the face on which a solid stands, from samples of its distance.
namespace brim::face_corner_test {
namespace {

constexpr double h = 0.1;

using testing::solid_side;

/// A solid that stands on the plane z = 0, sampled half a voxel apart.
std::shared_ptr<const Shape> sampled(const Aabb& box, const std::function<double(const Vec3&)>& distance) {
  return make_grid_shape(std::make_shared<const DistanceGrid>(sample_distance(box, 0.5 * h, distance)), 1.0);
}

/// The plane z = 0, turned and moved.
FacePlane plane_at(const Pose& world) { return {world.translation, world.rotation.col(2), 0.0, Vec3::Zero()}; }

Pose any_pose(std::mt19937& rng) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  return {rotation_from_vector(Vec3(unit(rng), unit(rng), unit(rng))).toRotationMatrix(),
          Vec3(unit(rng), unit(rng), unit(rng))};
}

TEST(FaceCorner, OfAPrismOfThreeToSixSidesEachIsFoundInItsDirection) {
  constexpr unsigned kSeed = 2;
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  const auto plane = make_half_space();
  for (const int sides : {3, 4, 5, 6}) {
    const double radius = 5.0 * h;
    // The largest distance to a face is right but beside edges, where it bends as samples do.
    const auto prism = sampled({Vec3(-1, -1, -0.4), Vec3(1, 1, 1.2)}, [&](const Vec3& p) {
      double d = std::abs(p.z() - 0.4) - 0.4;
      for (int k = 0; k < sides; ++k) {
        const double angle = 2.0 * M_PI * (k + 0.5) / sides;
        d = std::max(d, std::cos(angle) * p.x() + std::sin(angle) * p.y() - radius * std::cos(M_PI / sides));
      }
      return d;
    });
    for (int trial = 0; trial < 20; ++trial) {
      const Pose world = any_pose(rng);
      const CubeSide a = solid_side(prism, world), b = solid_side(plane, world);
      const FaceCorner face(a, b, h, plane_at(world));
      for (int k = 0; k < sides; ++k) {
        SCOPED_TRACE(::testing::Message() << sides << " sides, corner " << k << ", trial " << trial);
        const double angle = 2.0 * M_PI * k / sides, aside = angle + 0.15;
        const Vec3 corner(radius * std::cos(angle), radius * std::sin(angle), 0.0);
        // From two voxels before it, looking a little past it.
        const auto found = face.find(world.rotation * (0.6 * corner) + world.translation,
                                     world.rotation * Vec3(std::cos(aside), std::sin(aside), 0.0));
        ASSERT_TRUE(found.has_value());
        EXPECT_LT((world.to_local(*found) - corner).norm(), 0.1 * h);
      }
    }
  }
}

TEST(FaceCorner, OfADiscItIsThePointOfTheRim) {
  const double radius = 8.0 * h;
  const auto disc = sampled({Vec3(-1.2, -1.2, -0.4), Vec3(1.2, 1.2, 1.2)}, [&](const Vec3& p) {
    return std::max(std::abs(p.z() - 0.4) - 0.4, std::hypot(p.x(), p.y()) - radius);
  });
  std::mt19937 rng(3);
  const auto plane = make_half_space();
  for (int trial = 0; trial < 30; ++trial) {
    const Pose world = any_pose(rng);
    const CubeSide a = solid_side(disc, world), b = solid_side(plane, world);
    const double angle = 0.2 * trial;
    const Vec3 way(std::cos(angle), std::sin(angle), 0.0);
    const auto found = FaceCorner(a, b, h, plane_at(world))
                           .find(world.rotation * (6.0 * h * way) + world.translation, world.rotation * way);
    ASSERT_TRUE(found.has_value());
    EXPECT_LT((world.to_local(*found) - radius * way).norm(), 0.1 * h) << trial;
  }
}

TEST(FaceCorner, NothingIsFoundFarFromAnyEdge) {
  const auto box = make_box(Vec3(4, 4, 1)), plane = make_half_space();
  const CubeSide a = solid_side(box, {Mat3::Identity(), Vec3(0, 0, 0.5)}), b = solid_side(plane, {});
  EXPECT_FALSE(FaceCorner(a, b, h, plane_at({})).find(Vec3::Zero(), Vec3::UnitX()).has_value());
  EXPECT_FALSE(FaceCorner(a, b, h, plane_at({})).find(Vec3::Zero(), Vec3::UnitZ()).has_value())
      << "no way along the face";
}

}  // namespace
}  // namespace brim::face_corner_test
