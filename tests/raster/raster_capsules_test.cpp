#include <gtest/gtest.h>

#include "brim/core/error.h"
#include "brim/math/ramp.h"
#include "brim/raster/raster_points.h"
#include "brim/raster/raster_segments.h"
#include "support/solids.h"
#include "support/tiles.h"

namespace brim::raster_capsules_test {
namespace {

using testing::for_each_node;
using testing::tiles_around;

constexpr unsigned kSeed = 3;
/// Of distances, in voxels, by single precision; the ramp's slope at w = 3h is 1/2 per voxel.
constexpr double kDistanceError = 1e-5, kDensityError = 0.5 * kDistanceError;
const Aabb kEverywhere{Vec3::Constant(-1e9), Vec3::Constant(1e9)};

struct Chain {
  std::vector<Vec3> x;
  std::vector<std::array<std::int32_t, 2>> segments;
  std::vector<double> segment_radius, point_radius;
  Aabb box;

  Chain() {
    testing::Noise noise(kSeed);
    for (int i = 0; i < 40; ++i) {
      x.push_back(noise.vec());
      point_radius.push_back(0.1 + 0.05 * noise());
      box.extend(Aabb{x.back(), x.back()}.inflated(0.2));
      if (i > 0) segments.push_back({i - 1, i}), segment_radius.push_back(0.1 + 0.05 * noise());
    }
  }
};

TEST(RasterSegments, EqualsBruteForceAndPresenceHoldsIt) {
  SCOPED_TRACE(kSeed);
  const Chain c;
  const double h = 0.07, w = 3 * h;
  const auto tiles = tiles_around(c.box.inflated(2 * w), h);
  std::vector<DensityBlock> out(tiles.size());
  RasterWorkspace workspace;
  raster_segments(c.x, c.segments, c.segment_radius, tiles, h, w, out, workspace);
  for_each_node(tiles, h, [&](std::size_t b, int n, const Vec3& r) {
    const auto distance = [&](std::size_t i) {
      return testing::segment_distance(r, c.x[c.segments[i][0]], c.x[c.segments[i][1]]) - c.segment_radius[i];
    };
    double d = 1e9;
    for (std::size_t i = 0; i < c.segments.size(); ++i) d = std::min(d, distance(i));
    ASSERT_NEAR(out[b].rho[n], ramp(d, w), kDensityError);
    if (out[b].rho[n] > 0.0) {
      ASSERT_NEAR(distance(out[b].source[n]), d, kDistanceError * h);
    } else {
      ASSERT_EQ(out[b].source[n], -1);
    }
  });
  std::vector<TileKey> present;
  presence_segments(c.x, c.segments, c.segment_radius, h, w, kEverywhere, present, workspace);
  testing::expect_present(tiles, out, present);
  EXPECT_LT(present.size(), tiles.size());
}

TEST(RasterPoints, EqualsBruteForceAndPresenceHoldsIt) {
  SCOPED_TRACE(kSeed);
  const Chain c;
  const double h = 0.07, w = 3 * h;
  const auto tiles = tiles_around(c.box.inflated(2 * w), h);
  std::vector<DensityBlock> out(tiles.size());
  RasterWorkspace workspace;
  raster_points(c.x, c.point_radius, tiles, h, w, out, workspace);
  for_each_node(tiles, h, [&](std::size_t b, int n, const Vec3& r) {
    double d = 1e9;
    for (std::size_t i = 0; i < c.x.size(); ++i) d = std::min(d, (r - c.x[i]).norm() - c.point_radius[i]);
    ASSERT_NEAR(out[b].rho[n], ramp(d, w), kDensityError);
    if (out[b].rho[n] > 0.0) {
      const std::int32_t s = out[b].source[n];
      ASSERT_NEAR((r - c.x[s]).norm() - c.point_radius[s], d, kDistanceError * h);
    }
  });
  std::vector<TileKey> present;
  presence_points(c.x, c.point_radius, h, w, kEverywhere, present, workspace);
  testing::expect_present(tiles, out, present);
}

TEST(RasterPoints, OneBallByHand) {
  // Centre on node (3, 3, 3), R = 2 h, w = 4 h: 1/2 at two nodes along an axis, 1 at the centre, the first of twins
  // wins.
  const std::vector<Vec3> x = {{3, 3, 3}, {3, 3, 3}};
  std::vector<DensityBlock> out(1);
  RasterWorkspace workspace;
  raster_points(x, std::vector<double>{2.0}, std::vector<TileKey>{{0, 0, 0}}, 1.0, 4.0, out, workspace);
  EXPECT_EQ(out[0].rho[block_index(4, 4, 4)], 1.0);
  EXPECT_NEAR(out[0].rho[block_index(6, 4, 4)], 0.5, kDensityError);
  EXPECT_NEAR(out[0].rho[block_index(4, 4, 7)], 0.15625, kDensityError);
  EXPECT_EQ(out[0].source[block_index(4, 4, 4)], 0);
}

TEST(RasterPoints, DensityChangesSmoothlyAsBallsMove) {
  Chain c;
  const double h = 0.1, w = 3 * h, step = 0.01 * h;
  const auto tiles = tiles_around(c.box.inflated(w), h);
  std::vector<DensityBlock> out(tiles.size()), last;
  RasterWorkspace workspace;
  double largest = 0.0;
  for (int s = 0; s < 30; ++s) {
    raster_points(c.x, c.point_radius, tiles, h, w, out, workspace);
    for (std::size_t t = 0; t < last.size(); ++t)
      for (int n = 0; n < kBlockNodes; ++n) largest = std::max(largest, std::abs(out[t].rho[n] - last[t].rho[n]));
    last = out;
    for (Vec3& x : c.x) x += step * Vec3(2, -1, 2) / 3;
  }
  EXPECT_LE(largest, 1.5 * step / w + 2 * kDensityError);
  EXPECT_GT(largest, 1.4 * step / w);
}

TEST(RasterPoints, NothingGivesNothing) {
  std::vector<DensityBlock> out(1);
  RasterWorkspace workspace;
  raster_points({}, std::vector<double>{1.0}, std::vector<TileKey>{{0, 0, 0}}, 1.0, 3.0, out, workspace);
  EXPECT_EQ(out[0].rho[0], 0.0);
  EXPECT_EQ(out[0].source[0], -1);
  std::vector<TileKey> present;
  presence_points({}, std::vector<double>{1.0}, 1.0, 3.0, kEverywhere, present, workspace);
  EXPECT_TRUE(present.empty());
}

}  // namespace
}  // namespace brim::raster_capsules_test
