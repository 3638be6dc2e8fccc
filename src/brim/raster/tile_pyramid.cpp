#include "brim/raster/tile_pyramid.h"

#include <algorithm>

#include "brim/core/parallel.h"

namespace brim {

namespace {

constexpr int kReach = static_cast<int>(kBinomial.size()) / 2;
/// Nodes below that a block reads, along each axis.
constexpr int kRead = 2 * (kBlockSize - 1) + 1 + 2 * kReach;
/// Tiles below a tile that hold those: from 2 x − 1 on.
constexpr int kBelow = 4;

}  // namespace

std::vector<TileKey> tiles_below(std::span<const TileKey> tiles) {
  std::vector<TileKey> below;
  below.reserve(tiles.size() * 27);
  for (const TileKey& t : tiles)
    for (int z = -1; z < kBelow - 1; ++z)
      for (int y = -1; y < kBelow - 1; ++y)
        for (int x = -1; x < kBelow - 1; ++x) below.push_back({2 * t.x + x, 2 * t.y + y, 2 * t.z + z});
  sort_unique(below);
  return below;
}

void reduce_tiles(std::span<const TileKey> below, std::span<const DensityBlock> blocks, std::span<const TileKey> tiles,
                  std::span<DensityBlock> out) {
  parallel_for(tiles.size(), [&](std::size_t t) {
    DensityBlock& block = out[t];
    std::fill(std::begin(block.rho), std::end(block.rho), 0.0);
    std::fill(std::begin(block.source), std::end(block.source), 0);
    // All nodes that count, from node 2 (8 x − 1) − 3 of the level below on.
    std::vector<double> rho(static_cast<std::size_t>(kRead) * kRead * kRead, 0.0);
    std::vector<std::int32_t> source(rho.size(), 0);
    const auto at = [](int i, int j, int k) {
      return static_cast<std::size_t>(i) + static_cast<std::size_t>(kRead) * (j + static_cast<std::size_t>(kRead) * k);
    };
    constexpr int kFirst = -2 * kHalo - kReach;
    bool any = false;
    for (int c = 0; c < kBelow * kBelow * kBelow; ++c) {
      const int offset[3] = {c % kBelow - 1, c / kBelow % kBelow - 1, c / (kBelow * kBelow) - 1};
      const TileKey key{2 * tiles[t].x + offset[0], 2 * tiles[t].y + offset[1], 2 * tiles[t].z + offset[2]};
      const auto found = std::lower_bound(below.begin(), below.end(), key);
      if (found == below.end() || *found != key) continue;
      any = true;
      const DensityBlock& from = blocks[static_cast<std::size_t>(found - below.begin())];
      int lo[3], hi[3];  // own nodes of the tile below that are read
      for (int a = 0; a < 3; ++a) {
        lo[a] = std::max(0, kFirst - kTileSize * offset[a]);
        hi[a] = std::min(kTileSize - 1, kFirst + kRead - 1 - kTileSize * offset[a]);
      }
      for (int k = lo[2]; k <= hi[2]; ++k)
        for (int j = lo[1]; j <= hi[1]; ++j)
          for (int i = lo[0]; i <= hi[0]; ++i) {
            const std::size_t to = at(i + kTileSize * offset[0] - kFirst, j + kTileSize * offset[1] - kFirst,
                                      k + kTileSize * offset[2] - kFirst);
            const int n = block_index(i + kHalo, j + kHalo, k + kHalo);
            rho[to] = from.rho[n], source[to] = from.source[n];
          }
    }
    if (!any) return;
    // Along x, y and z in turn; each turn brings the next axis to the front.
    constexpr std::size_t r = kRead, b = kBlockSize;
    std::vector<double> one(b * r * r), two(b * b * r), three(b * b * b);
    for (std::size_t l = 0; l < r * r; ++l)
      for (std::size_t i = 0; i < b; ++i)
        for (std::size_t o = 0; o < kBinomial.size(); ++o) one[l + r * r * i] += kBinomial[o] * rho[2 * i + o + r * l];
    for (std::size_t l = 0; l < r * b; ++l)  // l = z + r x, values along y
      for (std::size_t j = 0; j < b; ++j)
        for (std::size_t o = 0; o < kBinomial.size(); ++o) two[l + r * b * j] += kBinomial[o] * one[2 * j + o + r * l];
    for (std::size_t l = 0; l < b * b; ++l)  // l = x + b y, values along z
      for (std::size_t k = 0; k < b; ++k)
        for (std::size_t o = 0; o < kBinomial.size(); ++o)
          three[l + b * b * k] += kBinomial[o] * two[2 * k + o + r * l];
    for (int k = 0; k < kBlockSize; ++k)
      for (int j = 0; j < kBlockSize; ++j)
        for (int i = 0; i < kBlockSize; ++i) {
          const int n = block_index(i, j, k);
          block.rho[n] = std::min(1.0, three[static_cast<std::size_t>(n)]);
          if (!(block.rho[n] > 0.0)) continue;
          std::size_t best = at(2 * i + kReach, 2 * j + kReach, 2 * k + kReach);
          if (!(rho[best] > 0.0))
            for (int c = -kReach; c <= kReach; ++c)
              for (int e = -kReach; e <= kReach; ++e)
                for (int d = -kReach; d <= kReach; ++d) {
                  const std::size_t m = at(2 * i + kReach + d, 2 * j + kReach + e, 2 * k + kReach + c);
                  if (rho[m] > rho[best]) best = m;
                }
          block.source[n] = source[best];
        }
  });
}

}  // namespace brim
