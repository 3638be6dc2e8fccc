#include "brim/raster/image_shape.h"

#include <gtest/gtest.h>

#include <random>

#include "brim/core/parallel.h"
#include "brim/math/ramp.h"
#include "brim/raster/ball_field.h"
#include "support/images.h"
#include "support/tiles.h"

namespace brim::image_shape_test {
namespace {

constexpr double kStep = 0.005, kH = 0.02, kW = 3 * kH;

OccupancyGrid grid_of(const auto& distance, double spacing = 0.5 * kH) {
  return sample_occupancy(testing::scan({Vec3::Constant(-0.22), Vec3::Constant(0.22)}, kStep, distance), {0, 100},
                          spacing);
}

TEST(BallField, AFlatSurfaceGivesTheRampWhateverItsDirectionAndPlace) {
  const unsigned seed = 12;
  SCOPED_TRACE(seed);
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> u(-1, 1);
  double worst = 0.0;
  for (int trial = 0; trial < 6; ++trial) {
    Vec3 n = trial < 3 ? Vec3(Vec3::Unit(trial)) : Vec3(u(rng), u(rng), u(rng)).normalized();
    const double at = kStep * u(rng);
    const auto plane = [&](const Vec3& x) { return n.dot(x) - at; };
    const BallField field(grid_of(plane), kW);
    for (int p = 0; p < 500; ++p) {
      const Vec3 x = 0.12 * Vec3(u(rng), u(rng), u(rng));
      worst = std::max(worst, std::abs(ramp(field.distance(x), kW) - ramp(plane(x), kW)));
    }
  }
  RecordProperty("worst", std::to_string(worst));
  EXPECT_LT(worst, 0.025);  // measured 0.017: rows of the ball are taken at the cells' centres
}

TEST(BallField, IsTheShareOfABallByBruteForce) {
  const auto lump = [](const Vec3& x) {
    return std::min((x - Vec3(0.04, 0, 0)).norm() - 0.08, std::max(x.cwiseAbs().maxCoeff() - 0.06, -x.x()));
  };
  const OccupancyGrid grid = grid_of(lump);
  const BallField field(grid, kW);
  const unsigned seed = 3;
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> u(-1, 1);
  const double radius = 0.5 * kW;
  for (int trial = 0; trial < 40; ++trial) {
    const Vec3 x = 0.14 * Vec3(u(rng), u(rng), u(rng));
    double in = 0.0, all = 0.0;
    for (int s = 0; s < 20000; ++s) {
      const Vec3 d(u(rng), u(rng), u(rng));
      if (d.squaredNorm() > 1.0) continue;
      all += 1.0;
      in += lump(x + radius * d) < 0.0;
    }
    EXPECT_NEAR(ramp(field.distance(x), kW), in / all, 0.03) << "seed " << seed;
  }
}

TEST(BallField, KeepsOnlyBricksAlongTheSurface) {
  const OccupancyGrid grid = grid_of([](const Vec3& x) { return x.norm() - 0.2; }, 0.004);
  const BallField field(grid, 0.024);
  EXPECT_LT(field.bytes(), grid.share.size() * 4);
  EXPECT_EQ(field.uniform({Vec3::Constant(-0.02), Vec3::Constant(0.02)}), -1);
  EXPECT_EQ(field.uniform({Vec3::Constant(0.5), Vec3::Constant(0.6)}), 1);
  EXPECT_EQ(field.uniform({Vec3::Constant(-0.02), Vec3(0.3, 0.02, 0.02)}), 0);
  EXPECT_EQ(field.distance(Vec3::Zero()), -0.012);
  EXPECT_EQ(field.distance(Vec3(9, 9, 9)), 0.012);
}

TEST(ImageShape, DistanceIsThatOfTheSphereItShows) {
  const unsigned seed = 5;
  SCOPED_TRACE(seed);
  std::mt19937 rng(seed);
  std::normal_distribution<double> normal;
  for (const double r : {0.06, 0.1, 0.18}) {
    const auto shape = make_image_shape(grid_of([&](const Vec3& x) { return x.norm() - r; }), 2.0 * r);
    // The sphere falls off from its tangent plane by b²/4r, averaged over the section of a ball of radius b: two cells.
    const double b = kH, rounded = 0.25 * b * b / r;
    for (const double off : {-kH, 0.0, kH, 3.0 * kH}) {
      double sum = 0.0, square = 0.0;
      const int n = 2000;
      for (int i = 0; i < n; ++i) {
        const Vec3 x = (r + off) * Vec3(normal(rng), normal(rng), normal(rng)).normalized();
        const double error = shape->distance(x) - off;
        sum += error, square += error * error;
      }
      const double mean = sum / n;
      EXPECT_NEAR(mean, rounded, 0.03 * kH) << r << " " << off;
      EXPECT_LT(std::sqrt(square / n - mean * mean), 0.01 * kH) << r << " " << off;
    }
  }
}

TEST(ImageShape, PlacedAndTurnedItGivesTheDensityOfTheSphereItShows) {
  const double r = 0.2;
  const auto shape = make_image_shape(grid_of([&](const Vec3& x) { return x.norm() - r; }), 0.4);
  const auto exact = make_sphere(r);
  Pose pose;
  pose.rotation = Eigen::AngleAxisd(1.0, Vec3(1, -1, 0.4).normalized()).toRotationMatrix();
  pose.translation = Vec3(0.33, -0.47, 1.21);
  for (const double h : {0.5 * kH, kH, 1.4 * kH}) {
    const double w = 3 * h;
    const auto tiles = testing::tiles_around(shape->placed_bounds(pose).inflated(w), h);
    std::vector<DensityBlock> blocks(tiles.size()), sphere(tiles.size());
    double worst = 0.0;
    for (std::size_t t = 0; t < tiles.size(); ++t) {
      shape->fill(pose, tiles[t], h, w, blocks[t]);
      exact->fill(pose, tiles[t], h, w, sphere[t]);
      for (int n = 0; n < kBlockNodes; ++n) worst = std::max(worst, std::abs(blocks[t].rho[n] - sphere[t].rho[n]));
    }
    RecordProperty("worst_" + std::to_string(h), std::to_string(worst));
    // The ramp rises by 3/2 of the distance's error over its width.
    EXPECT_LT(worst, 1.5 * 0.08 * kH / w) << h;
    std::vector<TileKey> present;
    shape_presence(*shape, pose, h, w, {Vec3::Constant(-9), Vec3::Constant(9)}, present);
    testing::expect_present(tiles, blocks, present);
    EXPECT_LT(present.size(), tiles.size());
  }
}

TEST(ImageShape, AFlatFaceLiesWhereItIsWhateverItsDirectionAndPlace) {
  const unsigned seed = 12;
  SCOPED_TRACE(seed);
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int trial = 0; trial < 6; ++trial) {
    const Vec3 n = trial < 3 ? Vec3(Vec3::Unit(trial)) : Vec3(u(rng), u(rng), u(rng)).normalized();
    const double at = kStep * u(rng);
    const auto plane = [&](const Vec3& x) { return n.dot(x) - at; };
    const DistanceGrid grid = distance_of_matter(grid_of(plane));
    for (int p = 0; p < 500; ++p) {
      const Vec3 x = 0.06 * Vec3(u(rng), u(rng), u(rng));
      EXPECT_NEAR(grid.value(x), plane(x), 0.03 * kH) << n.transpose();
    }
  }
}

/// Sheets from a cell down to a third of one, thinner than the balls that tell the surface, at several places and
/// angles; with a lump, as an image needs one cell that is half full.
TEST(ImageShape, ThinMatterIsKept) {
  const double cell = 0.5 * kH;
  for (const double thickness : {1.0, 0.5, 0.35})
    for (const double place : {0.0, 0.5})
      for (const Vec3& way : {Vec3(0, 0, 1), Vec3(0.3, 0.2, 1.0), Vec3(1, 1, 1)}) {
        const Vec3 n = way.normalized(), e = n.unitOrthogonal(), f = n.cross(e);
        const auto sheet = [&](const Vec3& x) {
          const double off = std::abs(n.dot(x) - place * cell) - 0.5 * thickness * cell;
          return std::min(std::max(off, x.cwiseAbs().maxCoeff() - 0.1), (x + 0.08 * n).norm() - 0.02);
        };
        const DistanceGrid grid = distance_of_matter(sample_occupancy(
            testing::scan({Vec3::Constant(-0.14), Vec3::Constant(0.14)}, 0.25 * cell, sheet), {0, 100}, cell));
        // From any place on the sheet the next matter is within a cell; two cells beside it there is none.
        double farthest = -1.0, nearest = 1.0;
        for (double u = -0.06; u < 0.06; u += 0.007)
          for (double v = -0.06; v < 0.06; v += 0.007) {
            const Vec3 x = place * cell * n + u * e + v * f;
            farthest = std::max(farthest, grid.value(x));
            nearest = std::min(nearest, grid.value(x + (0.5 * thickness + 2.0) * cell * n));
          }
        EXPECT_LT(farthest, cell) << thickness << " " << place << " " << n.transpose();
        EXPECT_GT(nearest, cell) << thickness << " " << place << " " << n.transpose();
      }
}

/// Images of voxels of four cells. Where their border fades, rows of cells that are equally faint, or that a bulge
/// makes a little fuller than their neighbours, are no thin matter: lumps of half a voxel lay there beside the surface.
TEST(ImageShape, TheFaintBorderOfCoarseVoxelsIsNoMatter) {
  const double voxel = 0.02, cell = 0.25 * voxel;
  const auto check = [&](const auto& distance, const char* what) {
    const DistanceGrid grid = distance_of_matter(sample_occupancy(
        testing::scan({Vec3(-0.18, -0.18, -0.13), Vec3(0.18, 0.18, 0.13)}, voxel, distance), {0, 100}, cell));
    double least = 0.0;
    for (double x = -0.17; x < 0.17; x += 0.004)
      for (double y = -0.17; y < 0.17; y += 0.004)
        for (double z = -0.12; z < 0.12; z += 0.004) {
          const double d = distance(Vec3(x, y, z));
          if (d > 0.0 && d < voxel) least = std::min(least, grid.value(Vec3(x, y, z)) - d);
        }
    EXPECT_GT(least, -0.15 * voxel) << what;
  };
  check([](const Vec3& x) { return (x.cwiseAbs() - Vec3(0.15, 0.15, 0.1)).maxCoeff(); }, "box");
  check([](const Vec3& x) { return x.norm() - 0.1; }, "ball");
}

TEST(ImageShape, ThreadsDoNotChangeABit) {
  std::vector<float> first;
  for (const int threads : {1, 2, 4}) {
    ThreadLimit limit(threads);
    const DistanceGrid grid = distance_of_matter(grid_of([](const Vec3& x) { return x.cwiseAbs().maxCoeff() - 0.1; }));
    if (first.empty()) first = grid.values();
    EXPECT_EQ(grid.values(), first);
  }
}

}  // namespace
}  // namespace brim::image_shape_test
