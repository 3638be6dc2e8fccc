#include "brim/raster/raster_tets.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cstring>

#include "brim/core/parallel.h"
#include "brim/math/ramp.h"
#include "support/solids.h"
#include "support/tiles.h"

namespace brim::raster_tets_test {
namespace {

using testing::for_each_node;
using testing::tiles_around;

constexpr unsigned kSeed = 11;
/// Of distances, in voxels: what single precision rounds, and nodes at a face that count as inside (twice 1e-5). The
/// ramp's slope at w = 3h is 1/2 per voxel.
constexpr double kDistanceError = 2e-5, kDensityError = 0.5 * kDistanceError;

/// A block, bent and shaken.
struct Solid {
  TetMesh mesh;
  testing::Boundary boundary;
  Aabb box;
  TetRasterWorkspace workspace;

  explicit Solid(double shake, int n = 4) : mesh(testing::block(n, n, n, 0.3)) {
    testing::Noise noise(kSeed);
    boundary = testing::boundary(mesh);
    for (Vec3& x : mesh.vertices) {
      x += shake * noise.vec() + shake * Vec3(std::sin(2 * x.y()), std::cos(3 * x.z()), x.x() * x.y());
      box.extend(x);
    }
  }
  TetSolid view() const { return {mesh.vertices, mesh.tets, boundary.triangles, boundary.owner}; }
  std::vector<DensityBlock> raster(const std::vector<TileKey>& tiles, double h, double w) {
    std::vector<DensityBlock> out(tiles.size());
    raster_tets(view(), tiles, h, w, out, workspace);
    return out;
  }
  std::array<Vec3, 4> corners(std::int32_t e) const {
    const auto& t = mesh.tets[e];
    return {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]], mesh.vertices[t[3]]};
  }
};

TEST(RasterTets, OneTetrahedronByHand) {
  // Node (1, 1, 1) is inside, 1 from each of the three axis planes; w = 4: rho = ramp(−1, 4) = 1 − 0.15625.
  const std::vector<Vec3> x = {{0, 0, 0}, {30, 0, 0}, {0, 30, 0}, {0, 0, 30}};
  const std::vector<Tetrahedron> tets = {{0, 1, 2, 3}};
  const std::vector<Triangle> surface = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  const std::vector<std::int32_t> owner(4, 0);
  std::vector<DensityBlock> out(1);
  TetRasterWorkspace workspace;
  raster_tets({x, tets, surface, owner}, std::vector<TileKey>{{0, 0, 0}}, 1.0, 4.0, out, workspace);
  const auto rho = [&](int i, int j, int k) { return out[0].rho[block_index(i + 1, j + 1, k + 1)]; };
  EXPECT_NEAR(rho(1, 1, 1), 0.84375, 1e-6);
  EXPECT_NEAR(rho(5, 0, 5), 0.5, 1e-6);
  EXPECT_NEAR(rho(5, -1, 5), 0.15625, 1e-6);
  EXPECT_EQ(rho(4, 4, 4), 1.0);
  EXPECT_EQ(out[0].source[block_index(6, 0, 6)], 0);
}

TEST(RasterTets, EqualsBruteForce) {
  SCOPED_TRACE(kSeed);
  Solid solid(0.06);
  const double h = 0.083, w = 3 * h;
  const auto tiles = tiles_around(solid.box.inflated(2 * w), h);
  const auto out = solid.raster(tiles, h, w);
  int inside_count = 0, band_count = 0;
  for_each_node(tiles, h, [&](std::size_t t, int n, const Vec3& r) {
    std::int32_t holder = -1;
    for (std::size_t e = 0; e < solid.mesh.tets.size() && holder < 0; ++e) {
      const auto b = tet_weights(r, solid.corners(static_cast<std::int32_t>(e)), 1e300);
      if (*std::min_element(b.begin(), b.end()) >= -1e-9) holder = static_cast<std::int32_t>(e);
    }
    double d = 1e9;
    for (const auto& s : solid.boundary.triangles)
      d = std::min(d, testing::triangle_distance(r, solid.mesh.vertices[s[0]], solid.mesh.vertices[s[1]],
                                                 solid.mesh.vertices[s[2]]));
    const double expected = ramp(holder >= 0 ? -d : d, w);
    ASSERT_NEAR(out[t].rho[n], expected, kDensityError);
    if (holder >= 0) {
      ASSERT_EQ(out[t].source[n], holder);
      ++inside_count;
    } else if (out[t].rho[n] > 0) {
      // The source owns a triangle that is as near as any.
      double nearest = 1e9;
      for (std::size_t s = 0; s < solid.boundary.triangles.size(); ++s)
        if (solid.boundary.owner[s] == out[t].source[n]) {
          const auto& c = solid.boundary.triangles[s];
          nearest = std::min(nearest, testing::triangle_distance(r, solid.mesh.vertices[c[0]],
                                                                 solid.mesh.vertices[c[1]], solid.mesh.vertices[c[2]]));
        }
      ASSERT_NEAR(nearest, d, kDistanceError * h);
      ++band_count;
    } else {
      ASSERT_EQ(out[t].source[n], -1);
    }
  });
  EXPECT_GT(inside_count, 1000);
  EXPECT_GT(band_count, 1000);
}

TEST(RasterTets, DensityOnTheSurfaceIsOneHalf) {
  Solid solid(0.06);
  // A grid that puts a node on the middle of each of some boundary triangles in turn.
  const double h = 0.05, w = 3 * h;
  for (std::size_t s = 0; s < solid.boundary.triangles.size(); s += 7) {
    const auto& c = solid.boundary.triangles[s];
    const Vec3 middle = (solid.mesh.vertices[c[0]] + solid.mesh.vertices[c[1]] + solid.mesh.vertices[c[2]]) / 3.0;
    Solid moved = solid;
    for (Vec3& x : moved.mesh.vertices) x -= middle;
    const auto out = moved.raster({{0, 0, 0}}, h, w);
    EXPECT_NEAR(out[0].rho[block_index(1, 1, 1)], 0.5, kDensityError);
  }
}

TEST(RasterTets, DensityChangesSmoothlyAsTheBodyMoves) {
  Solid solid(0.05);
  const double h = 0.1, w = 3 * h, step = 0.01 * h;
  const auto tiles = tiles_around(solid.box.inflated(w), h);
  std::vector<DensityBlock> last;
  double largest = 0.0;
  for (int s = 0; s < 40; ++s) {
    const auto out = solid.raster(tiles, h, w);
    if (!last.empty())
      for (std::size_t t = 0; t < tiles.size(); ++t)
        for (int n = 0; n < kBlockNodes; ++n) largest = std::max(largest, std::abs(out[t].rho[n] - last[t].rho[n]));
    last = out;
    for (Vec3& x : solid.mesh.vertices) x += step * Vec3(2, -1, 2) / 3;
  }
  // Distance has slope 1 and the ramp at most 1.5 / w.
  EXPECT_LE(largest, 1.5 * step / w + 2 * kDensityError);
  EXPECT_GT(largest, 1.4 * step / w);
}

TEST(RasterTets, WeightsReproduceConstantsAndPositions) {
  Solid solid(0.05);
  const double h = 0.07, w = 3 * h;
  const auto tiles = tiles_around(solid.box.inflated(w), h);
  const auto out = solid.raster(tiles, h, w);
  double largest = 0.0;
  for_each_node(tiles, h, [&](std::size_t t, int n, const Vec3& r) {
    if (out[t].rho[n] == 0.0) return;
    const auto x = solid.corners(out[t].source[n]);
    const auto b = tet_weights(r, x);
    Vec3 sum = Vec3::Zero();
    double magnitude = 0.0;
    for (int i = 0; i < 4; ++i) sum += b[i] * x[i], magnitude += std::abs(b[i]);
    EXPECT_NEAR(b[0] + b[1] + b[2] + b[3], 1.0, 1e-12);
    EXPECT_LT((sum - r).norm(), 1e-12);
    largest = std::max(largest, magnitude);
  });
  EXPECT_LT(largest, 6.0);
  EXPECT_GT(largest, 1.0);
}

TEST(RasterTets, FarPointOfASliverTakesTheClosestPoint) {
  const std::array<Vec3, 4> flat = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0.3, 0.3, 0)};
  const auto b = tet_weights(Vec3(0.25, 0.25, 0.5), flat);
  Vec3 p = Vec3::Zero();
  for (int i = 0; i < 4; ++i) p += b[i] * flat[i];
  EXPECT_LT((p - Vec3(0.25, 0.25, 0)).norm(), 1e-12);
}

TEST(RasterTets, PresenceNamesEveryTileWithDensityAndNoneOutsideTheRegion) {
  for (double h : {0.03, 0.11, 0.4}) {
    Solid solid(0.06);
    const double w = 3 * h;
    const auto tiles = tiles_around(solid.box.inflated(2 * w), h);
    const auto out = solid.raster(tiles, h, w);
    std::vector<TileKey> present;
    presence_tets(solid.view(), h, w, Aabb{Vec3::Constant(-1e6), Vec3::Constant(1e6)}, present, solid.workspace);
    testing::expect_present(tiles, out, present);
    EXPECT_LE(present.size(), tiles.size());
    const Aabb corner{solid.box.lo, solid.box.lo + Vec3::Constant(0.2)};
    std::vector<TileKey> clipped;
    presence_tets(solid.view(), h, w, corner, clipped, solid.workspace);
    EXPECT_FALSE(clipped.empty());
    for (const TileKey& t : clipped) EXPECT_TRUE(tile_box(t, h).inflated(h * 1.001).overlaps(corner));
  }
}

TEST(RasterTets, ThreadsAndOrderOfTilesDoNotChangeABit) {
  Solid solid(0.06);
  const double h = 0.05, w = 3 * h;
  auto tiles = tiles_around(solid.box.inflated(w), h);
  std::vector<DensityBlock> reference;
  for (int threads : {1, 2, 4}) {
    ThreadLimit limit(threads);
    const auto out = solid.raster(tiles, h, w);
    if (reference.empty()) reference = out;
    EXPECT_EQ(std::memcmp(out.data(), reference.data(), out.size() * sizeof(DensityBlock)), 0);
  }
  std::reverse(tiles.begin(), tiles.end());
  auto out = solid.raster(tiles, h, w);
  std::reverse(out.begin(), out.end());
  EXPECT_EQ(std::memcmp(out.data(), reference.data(), out.size() * sizeof(DensityBlock)), 0);
}

TEST(RasterTets, FarApartTilesAndBrokenPositionsAreSurvived) {
  Solid solid(0.0);
  const double h = 0.1;
  const std::vector<TileKey> tiles = {{0, 0, 0}, {30000, -30000, 30000}, {-30000, 5, 5}};
  const auto near = solid.raster({tiles[0]}, h, 0.3);
  const auto out = solid.raster(tiles, h, 0.3);
  EXPECT_EQ(std::memcmp(&out[0], &near[0], sizeof(DensityBlock)), 0);
  EXPECT_EQ(out[1].rho[0], 0.0);
  solid.mesh.vertices[0] = Vec3::Constant(std::nan(""));
  solid.mesh.vertices[1] = Vec3::Constant(1e30);
  EXPECT_NO_THROW(solid.raster(tiles, h, 0.3));
  std::vector<TileKey> present;
  EXPECT_NO_THROW(
      presence_tets(solid.view(), h, 0.3, {Vec3::Constant(-5), Vec3::Constant(5)}, present, solid.workspace));
}

}  // namespace
}  // namespace brim::raster_tets_test
