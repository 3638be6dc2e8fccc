#pragma once

#include <span>
#include <vector>

#include "brim/contact/cube_contacts.h"
#include "brim/core/parallel.h"

namespace brim::testing {

/// A tile on which two parts are both present.
struct PairTile {
  std::int32_t pair = 0;  ///< index into the pairs given to detect
  TileKey tile;
  const DensityBlock* a = nullptr;
  const DensityBlock* b = nullptr;
  Octants octants = kAllOctants;  ///< octants to search
};

/// Finds the contacts on the given tiles, which must be ordered by pair. `set.pairs` holds the pairs on entry; their
/// ranges and all arrays are filled. Same bits for any number of threads.
inline void detect(std::span<const PairTile> tiles, ContactSet& set) {
  std::vector<CubeFinds> finds(tiles.size());
  std::vector<PairFinds> pieces(tiles.size());
  parallel_for(tiles.size(), [&](std::size_t t) {
    const PairTile& tile = tiles[t];
    CubeSide a, b;
    a.block = tile.a, b.block = tile.b, a.tile = b.tile = tile.tile;
    find_in_tile(a, b, set.pairs[tile.pair], tile.tile, tile.octants, finds[t]);
    pieces[t] = {static_cast<std::size_t>(tile.pair), &finds[t]};
  });
  gather(pieces, set);
}

}  // namespace brim::testing
