#include "brim/raster/fill_tiles.h"

#include <gtest/gtest.h>

#include "brim/raster/shape.h"

namespace brim::fill_tiles_test {
namespace {

TEST(FillTiles, WritesWhatTheShapeOfTheSameDistanceWrites) {
  const double h = 0.1, w = 0.3;
  const auto ball = make_sphere(0.55);
  const Pose pose{Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix(), Vec3(0.3, -0.2, 0.11)};
  std::vector<TileKey> tiles;
  for (int z = -2; z < 2; ++z)
    for (int y = -2; y < 2; ++y)
      for (int x = -2; x < 2; ++x) tiles.push_back({x, y, z});
  std::vector<DensityBlock> blocks(tiles.size());
  fill_tiles([&](const Vec3& r) { return ball->distance(pose.to_local(r)); }, tiles, h, w, blocks);
  double least = 1.0, most = 0.0;
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    DensityBlock expected;
    ball->fill(pose, tiles[t], h, w, expected);
    for (int n = 0; n < kBlockNodes; ++n) {
      ASSERT_NEAR(blocks[t].rho[n], expected.rho[n], 1e-12);
      ASSERT_EQ(blocks[t].source[n], 0);
      least = std::min(least, blocks[t].rho[n]), most = std::max(most, blocks[t].rho[n]);
    }
  }
  EXPECT_EQ(least, 0.0);
  EXPECT_EQ(most, 1.0);
}

TEST(FillTiles, ANodeOnTheSurfaceHasHalfAndNoTilesAreFine) {
  const double h = 0.5;
  const TileKey tile{0, 0, 0};
  DensityBlock block;
  fill_tiles([](const Vec3& r) { return r.x() - 1.0; }, std::span(&tile, 1), h, 1.5, std::span(&block, 1));
  const int i = static_cast<int>((1.0 - block_origin(tile, h).x()) / h + 0.5);
  EXPECT_EQ(block.rho[block_index(i, 2, 3)], 0.5);
  EXPECT_EQ(block.rho[block_index(i - 2, 2, 3)], 1.0);
  EXPECT_EQ(block.rho[block_index(i + 2, 2, 3)], 0.0);
  fill_tiles([](const Vec3&) { return 0.0; }, {}, h, 1.5, {});
}

}  // namespace
}  // namespace brim::fill_tiles_test
