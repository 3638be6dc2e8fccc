#include "brim/raster/element_groups.h"

#include <gtest/gtest.h>

#include "brim/raster/tile_bins.h"
#include "brim/raster/tile_cover.h"
#include "support/solids.h"

namespace brim::element_groups_test {
namespace {

using Pair = std::array<std::int32_t, 2>;

/// 200 short edges along a line that winds through space, and the grid step.
struct Line {
  std::vector<Vec3> x;
  std::vector<Pair> edges;
  double h = 0.1;
  VertexNodes nodes;
  ElementGroups groups;
  Line() {
    testing::Noise noise(11);
    Vec3 at = Vec3::Zero();
    for (std::int32_t i = 0; i <= 200; ++i) {
      x.push_back(at);
      at += Vec3(0.15, 0.0, 0.0) + 0.1 * noise.vec();
      if (i > 0) edges.push_back({i - 1, i});
    }
    nodes.build(x, h, 1e-9);
    groups.build(std::span<const Pair>(edges));
  }
  NodeSpan of(std::size_t i) const { return nodes.around(edges[i]); }
};

TEST(ElementGroups, HoldTheNodesOfTheirElements) {
  const Line line;
  for (const std::int32_t more : {0, 2})
    for (std::size_t i = 0; i < line.edges.size(); ++i) {
      const NodeSpan own = line.of(i).grown(more),
                     group = line.groups.around(line.nodes, i / ElementGroups::kSize, more);
      for (int a = 0; a < 3; ++a) {
        EXPECT_LE(group.lo[a], own.lo[a]);
        EXPECT_GE(group.hi[a], own.hi[a]);
      }
    }
}

TEST(ElementGroups, PassByWhatIsNotWanted) {
  const Line line;
  std::size_t asked = 0;
  const auto box_of = [&](std::size_t i) { return ++asked, line.of(i); };
  const auto group_of = [&](std::size_t g) { return line.groups.around(line.nodes, g, 0); };
  const Aabb region{Vec3(9.0, -2.0, -2.0), Vec3(11.0, 2.0, 2.0)};

  // The cover of a region is the same, and few elements are looked at.
  TileCover cover;
  std::vector<OctantTile> all, near;
  cover.cover(region, line.h, all, BoxList{line.edges.size(), box_of});
  EXPECT_EQ(asked, line.edges.size());
  asked = 0;
  cover.cover(region, line.h, near, BoxList{line.edges.size(), box_of, group_of});
  EXPECT_LT(asked, line.edges.size() / 2);
  EXPECT_GT(asked, 0u);
  ASSERT_EQ(near.size(), all.size());
  ASSERT_FALSE(all.empty());
  std::vector<TileKey> tiles;
  for (std::size_t t = 0; t < all.size(); ++t) {
    EXPECT_EQ(near[t].tile, all[t].tile);
    EXPECT_EQ(near[t].octants, all[t].octants);
    tiles.push_back(all[t].tile);
  }

  // Bins lose nothing that has a wanted node.
  const NodeSpan wanted = nodes_in(region, line.h, 0.0);
  TileIndex index;
  index.build(tiles);
  TileBins whole, part;
  whole.build(index, tiles.size(), line.h, BoxList{line.edges.size(), box_of});
  asked = 0;
  part.build(index, tiles.size(), line.h, BoxList{line.edges.size(), box_of, group_of}, wanted);
  EXPECT_LT(asked, line.edges.size() / 2);
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    std::vector<std::int32_t> must, has(part.of(t).begin(), part.of(t).end());
    EXPECT_TRUE(std::ranges::is_sorted(has));
    for (const std::int32_t i : whole.of(t))
      if (line.of(static_cast<std::size_t>(i)).meets(wanted) && !line.of(static_cast<std::size_t>(i)).empty())
        must.push_back(i);
    EXPECT_TRUE(std::ranges::includes(has, must));
  }
}

}  // namespace
}  // namespace brim::element_groups_test
