#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "brim/grid/tile.h"
#include "brim/math/types.h"

namespace brim {

/// A tile on which two parts are both present.
struct PairTile {
  std::int32_t pair = 0;  ///< index into the pairs given to detect
  TileKey tile;
  const DensityBlock* a = nullptr;
  const DensityBlock* b = nullptr;
};

/// Two parts that may touch, and where their contacts are in a ContactSet.
struct ContactPair {
  std::int32_t part_a = 0, part_b = 0;  ///< global part numbers, part_a < part_b
  double h = 0.0;                       ///< [m] step at which they meet
  double w = 0.0;                       ///< [m] ramp width at that step
  double margin = 0.0;             ///< [-] nodes with ρ_a + ρ_b > 1 − margin are found: they may touch in this step
  std::size_t begin = 0, end = 0;  ///< contacts of the pair
};

/// Nodes where the densities of two parts sum to more than 1 (paper, section 4.1) or soon may, ordered by pair, tile
/// and node. Structure of arrays, each of shape (n).
struct ContactSet {
  std::vector<ContactPair> pairs;
  std::vector<Vec3> node;                    ///< [m] the grid point
  std::vector<Vec3> point;                   ///< [m] where the force is applied: the node carried to where ρ_a = ρ_b
  std::vector<double> overlap;               ///< [-] ρ̄ = ρ_a + ρ_b − 1, > −margin of the pair
  std::vector<double> depth;                 ///< [m] penetration: minus the sum of the distances to the two surfaces
  std::vector<Vec3> gradient_a, gradient_b;  ///< [1/m] ∇ρ
  std::vector<Mat3> curvature_a, curvature_b;  ///< [1/m²] T H T, tangential second derivatives of ρ
  std::vector<std::int32_t> source_a, source_b;
  std::int64_t engulfed = 0;  ///< overlapping nodes without any gradient: one part deep inside the other

  std::size_t size() const { return node.size(); }
  void resize(std::size_t n);
};

/// Finds the contacts on the given tiles, which must be ordered by pair. `set.pairs` holds the pairs on entry; their
/// ranges and all arrays are filled. Same bits for any number of threads.
void detect(std::span<const PairTile> tiles, ContactSet& set);

}  // namespace brim
