#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "brim/grid/tile.h"

namespace brim::testing {

/// All tiles whose block has a node in a box.
inline std::vector<TileKey> tiles_around(const Aabb& box, double h) {
  const TileRange r = tiles_meeting(box.inflated(h), h);
  std::vector<TileKey> tiles;
  for (int z = r.lo.z; z <= r.hi.z; ++z)
    for (int y = r.lo.y; y <= r.hi.y; ++y)
      for (int x = r.lo.x; x <= r.hi.x; ++x) tiles.push_back({x, y, z});
  return tiles;
}

/// Every tile of `blocks` that has density is in `present`.
inline void expect_present(const std::vector<TileKey>& tiles, const std::vector<DensityBlock>& blocks,
                           std::vector<TileKey> present) {
  std::sort(present.begin(), present.end());
  std::size_t filled = 0;
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    if (*std::max_element(std::begin(blocks[t].rho), std::end(blocks[t].rho)) == 0.0) continue;
    ++filled;
    EXPECT_TRUE(std::binary_search(present.begin(), present.end(), tiles[t]))
        << "tile " << tiles[t].x << " " << tiles[t].y << " " << tiles[t].z;
  }
  EXPECT_GT(filled, 0u);
}

template <class F>
void for_each_node(const std::vector<TileKey>& tiles, double h, const F& f) {
  for (std::size_t t = 0; t < tiles.size(); ++t)
    for (int k = 0; k < kBlockSize; ++k)
      for (int j = 0; j < kBlockSize; ++j)
        for (int i = 0; i < kBlockSize; ++i)
          f(t, block_index(i, j, k), Vec3(block_origin(tiles[t], h) + h * Vec3(i, j, k)));
}

}  // namespace brim::testing
