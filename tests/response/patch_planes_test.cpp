#include "brim/response/patch_planes.h"

#include <gtest/gtest.h>

#include <random>

#include "brim/math/rotation.h"
#include "brim/mesh/distance_grid.h"
#include "brim/raster/grid_shape.h"
#include "contact/solid_side.h"

/// Planes from the distances to a solid, at places rather than at nodes.
namespace brim::patch_planes_test {
namespace {

constexpr double h = 0.1;

using testing::solid_side;

TEST(PatchPlanes, ASmallFaceIsToldWithItsNormalAndDistance) {
  constexpr unsigned kSeed = 4;
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const Vec3 half(2.0 * h, 2.0 * h, 3.0 * h);
  const auto exact = [&](const Vec3& p) {
    const Vec3 q = p.cwiseAbs() - half;
    return q.cwiseMax(0.0).norm() + std::min(0.0, q.maxCoeff());
  };
  const auto block = make_grid_shape(std::make_shared<const DistanceGrid>(
                                         sample_distance({Vec3::Constant(-0.7), Vec3::Constant(0.7)}, 0.5 * h, exact)),
                                     0.3);
  for (int trial = 0; trial < 100; ++trial) {
    const Pose pose{rotation_from_vector(2.0 * Vec3(unit(rng), unit(rng), unit(rng))).toRotationMatrix(),
                    Vec3(unit(rng), unit(rng), unit(rng))};
    const double d = 0.1 * h * unit(rng);
    const Vec3 x = pose.rotation * Vec3(0.3 * h * unit(rng), 0.3 * h * unit(rng), half.z() + d) + pose.translation;
    const Vec3 n = pose.rotation.col(2);
    const Vec3 about = (n + 0.05 * Vec3(unit(rng), unit(rng), unit(rng))).normalized();
    SurfacePlane plane;
    ASSERT_TRUE(probe_plane(solid_side(block, pose), x, about, h, plane)) << trial;
    EXPECT_NEAR(plane.gap, d, 1e-4 * h);
    EXPECT_LT((plane.slope - n).norm(), 1e-3);
  }
}

TEST(PatchPlanes, NeitherABallNorAnEdgeIsAPlane) {
  const auto ball = make_sphere(2.0), box = make_box(Vec3::Ones());
  SurfacePlane plane;
  EXPECT_FALSE(probe_plane(solid_side(ball, {}), Vec3(0, 0, 2), Vec3::UnitZ(), h, plane));
  EXPECT_FALSE(probe_plane(solid_side(box, {}), Vec3(0.5 - 0.2 * h, 0, 0.5), Vec3::UnitZ(), h, plane));
  EXPECT_TRUE(probe_plane(solid_side(box, {}), Vec3(0.5 - h, 0, 0.5), Vec3::UnitZ(), h, plane));
}

}  // namespace
}  // namespace brim::patch_planes_test
