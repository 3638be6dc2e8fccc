#include "brim/raster/tile_pyramid.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "brim/math/ramp.h"

namespace brim::tile_pyramid_test {
namespace {

/// Blocks of a density given by a function of the node, on tiles of step 1.
template <class Density>
std::vector<DensityBlock> sampled(std::span<const TileKey> tiles, const Density& density) {
  std::vector<DensityBlock> blocks(tiles.size());
  for (std::size_t t = 0; t < tiles.size(); ++t)
    for (int k = 0; k < kBlockSize; ++k)
      for (int j = 0; j < kBlockSize; ++j)
        for (int i = 0; i < kBlockSize; ++i) {
          const Vec3 x = block_origin(tiles[t], 1.0) + Vec3(i, j, k);
          const int n = block_index(i, j, k);
          blocks[t].rho[n] = density(x);
          blocks[t].source[n] = blocks[t].rho[n] > 0.0 ? static_cast<std::int32_t>(1000 + x.x()) : -1;
        }
  return blocks;
}

TEST(TilePyramid, AgreesWithTheSumOverAllNeighboursByHand) {
  const auto density = [](const Vec3& x) { return 0.5 + 0.4 * std::sin(0.7 * x.x() + 0.3 * x.y() * x.z() + x.z()); };
  const std::vector<TileKey> tiles = {{0, 0, 0}, {-1, 0, 2}};
  const std::vector<TileKey> below = tiles_below(tiles);
  std::vector<DensityBlock> out(tiles.size());
  reduce_tiles(below, sampled(below, density), tiles, out);
  for (std::size_t t = 0; t < tiles.size(); ++t)
    for (const Vec3i& at : {Vec3i(0, 0, 0), Vec3i(9, 9, 9), Vec3i(3, 0, 7), Vec3i(5, 8, 1)}) {
      const Vec3 x = 2.0 * (block_origin(tiles[t], 1.0) + at.cast<double>());
      double sum = 0.0;
      for (int c = -3; c <= 3; ++c)
        for (int b = -3; b <= 3; ++b)
          for (int a = -3; a <= 3; ++a)
            sum += kBinomial[a + 3] * kBinomial[b + 3] * kBinomial[c + 3] * density(x + Vec3(a, b, c));
      EXPECT_NEAR(out[t].rho[block_index(at.x(), at.y(), at.z())], sum, 1e-14);
    }
}

TEST(TilePyramid, KeepsAFlatSurfaceWhereItIsAndItsRampThreeToThreeAndAFifthStepsWide) {
  // Two levels above a tilted plane; the width is that of the ramp of equal variance of its slope.
  const Vec3 n = Vec3(0.3, 0.2, 1.0).normalized();
  const auto density = [&](const Vec3& x) { return ramp(n.dot(x) - 0.3, 3.0); };
  const std::vector<TileKey> top = {{0, 0, 0}, {0, 0, -1}, {-1, 0, 0}, {-1, 0, -1}};
  const std::vector<TileKey> middle = tiles_below(top), below = tiles_below(middle);
  std::vector<DensityBlock> half(middle.size()), out(top.size());
  reduce_tiles(below, sampled(below, density), middle, half);
  reduce_tiles(middle, half, top, out);
  double worst = 0.0;
  for (std::size_t t = 0; t < top.size(); ++t)
    for (int k = 0; k < kBlockSize; ++k)
      for (int j = 0; j < kBlockSize; ++j)
        for (int i = 0; i < kBlockSize; ++i) {
          const double d = n.dot(4.0 * (block_origin(top[t], 1.0) + Vec3(i, j, k))) - 0.3;
          // A binomial mean has a Gaussian's tails, which a ramp has not: 0.027 off at most.
          worst = std::max(worst, std::abs(out[t].rho[block_index(i, j, k)] - ramp(d, 4.0 * 3.15)));
        }
  EXPECT_LT(worst, 0.03);
}

TEST(TilePyramid, SourcesAreThoseOfMatterNearby) {
  const auto density = [](const Vec3& x) { return ramp(x.x() - 0.4, 3.0); };
  const std::vector<TileKey> tiles = {{0, 0, 0}};
  const std::vector<TileKey> below = tiles_below(tiles);
  std::vector<DensityBlock> out(1);
  reduce_tiles(below, sampled(below, density), tiles, out);
  int found = 0;
  for (int i = 0; i < kBlockSize; ++i) {
    const int n = block_index(i, 4, 4);
    if (!(out[0].rho[n] > 0.0)) continue;
    ++found;
    EXPECT_NEAR(out[0].source[n] - 1000, 2 * (i - 1), 3) << "at most the filter's reach away";
  }
  EXPECT_GE(found, 3);
}

TEST(TilePyramid, MissingTilesAreEmpty) {
  const std::vector<TileKey> tiles = {{0, 0, 0}};
  std::vector<DensityBlock> out(1);
  reduce_tiles({}, {}, tiles, out);
  EXPECT_TRUE(std::all_of(std::begin(out[0].rho), std::end(out[0].rho), [](double r) { return r == 0.0; }));
}

}  // namespace
}  // namespace brim::tile_pyramid_test
