#include "brim/raster/grid_shape.h"

#include <gtest/gtest.h>

#include <random>

#include "brim/math/ramp.h"
#include "brim/math/rotation.h"
#include "brim/mesh/primitives.h"
#include "support/tiles.h"

namespace brim::grid_shape_test {
namespace {

using testing::expect_present;
using testing::for_each_node;
using testing::tiles_around;

constexpr unsigned kSeed = 62;
constexpr double kSpacing = 0.05;

std::shared_ptr<const DistanceGrid> sampled(const Shape& shape) {
  return std::make_shared<DistanceGrid>(sample_distance(shape.bounds().inflated(4 * kSpacing), kSpacing,
                                                        [&](const Vec3& p) { return shape.distance(p); }));
}

Pose random_pose(std::mt19937& rng) {
  std::uniform_real_distribution<double> u(-2.0, 2.0);
  const double a = u(rng), b = u(rng), c = u(rng), x = u(rng), y = u(rng);
  return {rotation_from_vector(Vec3(a, b, c)).toRotationMatrix(), Vec3(x, y, u(rng))};
}

TEST(GridShape, DensityOfASampledSphereIsThatOfTheAnalyticOne) {
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  const auto analytic = make_sphere(1.0);
  const auto shape = make_grid_shape(sampled(*analytic), 2.0);
  EXPECT_EQ(shape->thickness(), 2.0);
  const double h = kSpacing, w = 3 * h;
  for (int trial = 0; trial < 3; ++trial) {
    const Pose pose = random_pose(rng);
    const auto tiles = tiles_around(analytic->placed_bounds(pose).inflated(w), h);
    double worst = 0.0, square = 0.0, count = 0.0;
    for (const TileKey& t : tiles) {
      DensityBlock a, b;
      analytic->fill(pose, t, h, w, a);
      shape->fill(pose, t, h, w, b);
      for (int i = 0; i < kBlockNodes; ++i) {
        const double e = std::abs(a.rho[i] - b.rho[i]);
        worst = std::max(worst, e);
        if (a.rho[i] > 0.0 && a.rho[i] < 1.0) square += e * e, ++count;
      }
    }
    // distance_grid.h states 0.01 % in the root mean square for a sphere of 20 spacings.
    EXPECT_LT(std::sqrt(square / count), 2e-4);
    EXPECT_LT(worst, 2e-3);
    RecordProperty("root_mean_square", std::to_string(std::sqrt(square / count)));
    RecordProperty("worst", std::to_string(worst));
  }
}

TEST(GridShape, BoundsHoldTheSolid) {
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  const TriMesh mesh = shapes::blob(3, 1.0, 4);
  const auto shape =
      make_grid_shape(std::make_shared<DistanceGrid>(make_distance_grid(mesh, {.spacing = kSpacing})), 1.0);
  for (int trial = 0; trial < 5; ++trial) {
    const Pose pose = random_pose(rng);
    const Aabb box = shape->placed_bounds(pose);
    for (const Vec3& p : mesh.vertices) {
      const Vec3 x = pose.rotation * p + pose.translation;
      ASSERT_TRUE((x.array() >= box.lo.array()).all() && (x.array() <= box.hi.array()).all());
    }
  }
}

TEST(GridShape, PresenceListsEveryTileWhoseBlockHasDensity) {
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  const double h = 0.04, w = 3 * h;
  const auto shape = make_grid_shape(
      std::make_shared<DistanceGrid>(make_distance_grid(shapes::blob(7, 0.8, 4), {.spacing = kSpacing})), 0.8);
  for (int trial = 0; trial < 4; ++trial) {
    const Pose pose = random_pose(rng);
    const Aabb region = shape->placed_bounds(pose).inflated(8 * h);
    const auto tiles = tiles_around(region, h);
    std::vector<DensityBlock> blocks(tiles.size());
    for_each_node(tiles, h, [&](std::size_t t, int node, const Vec3& x) {
      blocks[t].rho[node] = ramp(shape->distance(pose.to_local(x)), w);
    });
    std::vector<TileKey> present;
    shape_presence(*shape, pose, h, w, region.inflated(20 * h), present);
    expect_present(tiles, blocks, present);
  }
}

}  // namespace
}  // namespace brim::grid_shape_test
