#include "brim/raster/raster_triangles.h"

#include <gtest/gtest.h>

#include <cstring>

#include "brim/math/ramp.h"
#include "support/solids.h"
#include "support/tiles.h"

namespace brim::raster_triangles_test {
namespace {

using testing::for_each_node;
using testing::tiles_around;

constexpr unsigned kSeed = 5;
/// Of distances, in voxels, by single precision; the ramp's slope at w = 3h is 1/2 per voxel.
constexpr double kDistanceError = 4e-6, kDensityError = 0.5 * kDistanceError;

struct Sheet {
  std::vector<Vec3> x;
  std::vector<Triangle> triangles;
  Aabb box;
  RasterWorkspace workspace;

  explicit Sheet(double shake, int n = 6) {
    testing::Noise noise(kSeed);
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        x.push_back(Vec3(0.2 * i, 0.2 * j, 0.3 * std::sin(i + 0.5 * j)) + shake * noise.vec());
        box.extend(x.back());
      }
    const auto at = [n](int i, int j) { return i + (n + 1) * j; };
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        triangles.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
        triangles.push_back({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
      }
  }
  double distance(const Vec3& r, std::size_t i) const {
    const auto& c = triangles[i];
    return testing::triangle_distance(r, x[c[0]], x[c[1]], x[c[2]]);
  }
  std::vector<DensityBlock> raster(const std::vector<TileKey>& tiles, double t, double h, double w) {
    std::vector<DensityBlock> out(tiles.size());
    raster_triangles(x, triangles, t, tiles, h, w, out, workspace);
    return out;
  }
};

TEST(RasterTriangles, FlatSheetByHand) {
  // A large triangle in z = 0; w = 4, t = 2: rho = ramp(|z| − 1, 4).
  const std::vector<Vec3> x = {{-50, -50, 0}, {50, -50, 0}, {0, 80, 0}};
  const std::vector<Triangle> triangles = {{0, 1, 2}};
  std::vector<DensityBlock> out(1);
  RasterWorkspace workspace;
  raster_triangles(x, triangles, 2.0, std::vector<TileKey>{{0, 0, 0}}, 1.0, 4.0, out, workspace);
  const double expected[] = {0.5, 0.84375, 0.5, 0.15625, 0.0, 0.0};
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(out[0].rho[block_index(3, 3, k)], expected[k], kDensityError) << k;
}

TEST(RasterTriangles, EqualsBruteForce) {
  SCOPED_TRACE(kSeed);
  Sheet sheet(0.05);
  const double h = 0.06, w = 3 * h, t = 2 * h;
  const auto tiles = tiles_around(sheet.box.inflated(2 * w), h);
  const auto out = sheet.raster(tiles, t, h, w);
  int count = 0;
  for_each_node(tiles, h, [&](std::size_t b, int n, const Vec3& r) {
    double d = 1e9;
    for (std::size_t i = 0; i < sheet.triangles.size(); ++i) d = std::min(d, sheet.distance(r, i));
    ASSERT_NEAR(out[b].rho[n], ramp(d - 0.5 * t, w), kDensityError);
    if (out[b].rho[n] == 0.0) {
      ASSERT_EQ(out[b].source[n], -1);
      return;
    }
    ASSERT_NEAR(sheet.distance(r, out[b].source[n]), d, kDistanceError * h);
    ++count;
  });
  EXPECT_GT(count, 1000);
}

TEST(RasterTriangles, DensityChangesSmoothlyAsTheSheetMoves) {
  Sheet sheet(0.02);
  const double h = 0.1, w = 3 * h, step = 0.01 * h;
  const auto tiles = tiles_around(sheet.box.inflated(w), h);
  std::vector<DensityBlock> last;
  double largest = 0.0;
  for (int s = 0; s < 40; ++s) {
    const auto out = sheet.raster(tiles, h, h, w);
    if (!last.empty())
      for (std::size_t t = 0; t < tiles.size(); ++t)
        for (int n = 0; n < kBlockNodes; ++n) largest = std::max(largest, std::abs(out[t].rho[n] - last[t].rho[n]));
    last = out;
    for (Vec3& x : sheet.x) x += step * Vec3(2, -1, 2) / 3;
  }
  EXPECT_LE(largest, 1.5 * step / w + 2 * kDensityError);
  EXPECT_GT(largest, 1.2 * step / w);
}

TEST(RasterTriangles, PresenceNamesEveryTileWithDensity) {
  for (double h : {0.02, 0.1, 0.5}) {
    Sheet sheet(0.05);
    const double w = 3 * h, t = 1.5 * h;
    const auto tiles = tiles_around(sheet.box.inflated(2 * w), h);
    std::vector<TileKey> present;
    presence_triangles(sheet.x, sheet.triangles, t, h, w, Aabb{Vec3::Constant(-1e9), Vec3::Constant(1e9)}, present,
                       sheet.workspace);
    testing::expect_present(tiles, sheet.raster(tiles, t, h, w), present);
  }
}

TEST(RasterTriangles, TriangleWithoutAreaIsItsLongestEdge) {
  Sheet sheet(0.0);
  sheet.x = {{0, 0, 0}, {0.5, 0.25, 0}, {1, 0.5, 0}, {0.3, 0.3, 0.3}};
  sheet.triangles = {{0, 1, 2}, {3, 3, 3}};
  const double h = 0.1, w = 0.3, t = 0.2;
  const auto tiles = tiles_around(Aabb{Vec3::Constant(-0.5), Vec3::Constant(1.5)}, h);
  const auto out = sheet.raster(tiles, t, h, w);
  for_each_node(tiles, h, [&](std::size_t b, int n, const Vec3& r) {
    const double d = std::min(testing::segment_distance(r, sheet.x[0], sheet.x[2]), (r - sheet.x[3]).norm());
    ASSERT_NEAR(out[b].rho[n], ramp(d - 0.5 * t, w), kDensityError);
  });
}

}  // namespace
}  // namespace brim::raster_triangles_test
