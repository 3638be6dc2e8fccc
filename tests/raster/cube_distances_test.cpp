#include "brim/raster/cube_distances.h"

#include <gtest/gtest.h>

#include <random>

#include "brim/math/ramp.h"
#include "brim/math/rotation.h"
#include "brim/mesh/distance_grid.h"
#include "brim/mesh/primitives.h"
#include "brim/raster/grid_shape.h"
#include "brim/raster/known_distance.h"

namespace brim::cube_distances_test {
namespace {

constexpr unsigned kSeed = 61;

TEST(CubeDistances, AreThoseOfTheShapeInSinglePrecision) {
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<double> in(-1.0, 1.0);
  const auto vector = [&] {
    const double x = in(rng), y = in(rng);
    return Vec3(x, y, in(rng));
  };
  DistanceGridOptions fine;
  fine.spacing = 0.05;
  const std::shared_ptr<const Shape> shapes[] = {
      make_sphere(0.6),
      make_box(Vec3(1.2, 0.7, 0.4)),
      make_capsule(0.3, 0.9),
      make_cylinder(0.5, 0.6),
      make_torus(0.6, 0.25),
      make_bowl(0.7, 0.2),
      make_cup(0.5, 0.8, 0.15),
      make_half_space(),
      make_grid_shape(std::make_shared<DistanceGrid>(make_distance_grid(shapes::torus(0.6, 0.25, 48, 24), fine)), 0.5)};
  std::size_t near = 0;
  for (int trial = 0; trial < 180; ++trial) {
    const Shape& shape = *shapes[trial % std::size(shapes)];
    const auto& known = dynamic_cast<const KnownDistance&>(shape);
    const Pose pose{rotation_from_vector(3.0 * vector()).toRotationMatrix(), vector()};
    const NodeCube cube{(10.0 * vector()).cast<int>(), 0.08};
    NodeMask wanted;
    for (auto& plane : wanted.plane) plane = rng() & rng();
    alignas(32) float d[kCubeNodes];
    known.cube_distances(pose, cube, wanted, 0.12, d);
    wanted.for_rows([&](int j, int k, std::uint8_t row) {
      for (int i = 0; i < kCubeSize; ++i) {
        if (!(row >> i & 1)) continue;
        const double exact = shape.distance(pose.to_local(cube.origin() + cube.h * Vec3(i, j, k)));
        if (std::abs(exact) > 0.12) {
          EXPECT_GT(std::abs(d[cube_index(i, j, k)]), 0.1199f);
          EXPECT_EQ(std::signbit(d[cube_index(i, j, k)]), std::signbit(exact));
        } else {
          EXPECT_NEAR(d[cube_index(i, j, k)], exact, 1e-6) << "trial " << trial;
          ++near;
        }
      }
    });
  }
  EXPECT_GT(near, 500u);
}

TEST(CubeDistances, OfALargeBoxKeepTheirDigitsAtItsFaces) {
  // Ten kilometres wide, and a face that lies a tenth of a millimetre above the nodes.
  const auto box = make_box(Vec3::Constant(1e4));
  const Pose pose{Mat3::Identity(), Vec3(0, 0, -5000.0 + 1e-4)};
  alignas(32) float d[kCubeNodes];
  const NodeCube cube{Vec3i(0, 0, -4), 0.01};
  dynamic_cast<const KnownDistance&>(*box).cube_distances(pose, cube, NodeMask::box(Vec3i::Zero(), Vec3i::Constant(7)),
                                                          0.015, d);
  for (int k = 0; k < kCubeSize; ++k) EXPECT_NEAR(d[cube_index(3, 3, k)], 0.01 * (k - 4) - 1e-4, 1e-8);
}

TEST(CubeRamp, IsTheRampOfEveryDistance) {
  alignas(32) float d[kCubeNodes], rho[kCubeNodes];
  for (int n = 0; n < kCubeNodes; ++n) d[n] = 0.001f * static_cast<float>(n - 256);
  cube_ramp(d, 0.3, NodeMask::box(Vec3i::Zero(), Vec3i::Constant(7)), rho);
  for (int n = 0; n < kCubeNodes; ++n) EXPECT_NEAR(rho[n], ramp(d[n], 0.3), 1e-6);
  EXPECT_EQ(rho[0], 1.0f);
  EXPECT_EQ(rho[kCubeNodes - 1], 0.0f);
}

}  // namespace
}  // namespace brim::cube_distances_test
