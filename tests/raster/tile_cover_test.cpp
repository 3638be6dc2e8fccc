#include "brim/raster/tile_cover.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "support/solids.h"

namespace brim::tile_cover_test {
namespace {

constexpr unsigned kSeed = 17;

/// The octants with an own node in some of the boxes and the region, node by node.
std::map<TileKey, Octants> by_nodes(const std::vector<Aabb>& boxes, const Aabb& region, double h) {
  std::map<TileKey, Octants> found;
  const auto below = [](int n, int size) { return n >= 0 ? n / size : -((size - 1 - n) / size); };
  for (const Aabb& whole : boxes) {
    const Aabb box = whole.intersection(region);
    for (int k = -40; k <= 40; ++k)
      for (int j = -40; j <= 40; ++j)
        for (int i = -40; i <= 40; ++i) {
          const Vec3 r = h * Vec3(i, j, k);
          if (!((r.array() >= box.lo.array()).all() && (r.array() <= box.hi.array()).all())) continue;
          const TileKey t{below(i, kTileSize), below(j, kTileSize), below(k, kTileSize)};
          const int x = (i - kTileSize * t.x) / 4, y = (j - kTileSize * t.y) / 4, z = (k - kTileSize * t.z) / 4;
          found[t] |= static_cast<Octants>(1 << (x + 2 * y + 4 * z));
        }
  }
  return found;
}

TEST(TileCover, NamesTheOctantsWithANodeInABox) {
  SCOPED_TRACE(kSeed);
  testing::Noise noise(kSeed);
  for (int round = 0; round < 20; ++round) {
    const double h = 0.11;
    std::vector<Aabb> boxes;
    for (int b = 0; b < 6; ++b) {
      const Vec3 center = 2.0 * noise.vec(), half = 0.5 * noise.vec().cwiseAbs();
      boxes.push_back({center - half, center + half});
    }
    boxes.push_back({Vec3::Constant(std::nan("")), Vec3::Constant(1.0)});
    const Aabb region{Vec3(-1.7, -1.9, -1.1), Vec3(1.3, 1.8, 2.1)};
    TileCover cover;
    std::vector<OctantTile> out;
    cover.cover(region, h, out, BoxList{boxes.size(), [&](std::size_t i) { return boxes[i]; }});
    boxes.pop_back();
    const auto expected = by_nodes(boxes, region, h);
    ASSERT_EQ(out.size(), expected.size());
    for (const OctantTile& t : out) {
      ASSERT_TRUE(expected.contains(t.tile));
      EXPECT_EQ(t.octants, expected.at(t.tile));
    }
  }
}

TEST(TileCover, HugeRegionsTakeMoreThanNeededNeverLess) {
  TileCover cover;
  std::vector<OctantTile> out;
  const Aabb box{Vec3(5.0, 6.0, 7.0), Vec3(5.1, 6.1, 7.1)};
  cover.cover(Aabb{Vec3::Constant(-1e3), Vec3::Constant(1e3)}, 0.1, out,
              BoxList{std::size_t{1}, [&](std::size_t) { return box; }});
  const TileKey wanted{6, 7, 8};
  EXPECT_TRUE(std::any_of(out.begin(), out.end(), [&](const OctantTile& t) { return t.tile == wanted; }));
}

}  // namespace
}  // namespace brim::tile_cover_test
