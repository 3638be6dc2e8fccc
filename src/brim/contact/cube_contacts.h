#pragma once

#include <vector>

#include "brim/contact/contact_set.h"
#include "brim/grid/node_cube.h"
#include "brim/raster/known_distance.h"

namespace brim {

/// Source of one part's densities on cubes: a solid sampled where needed, or the block of a tile.
struct CubeSide {
  const KnownDistance* solid = nullptr;
  Pose pose;                            ///< of the solid
  const DensityBlock* block = nullptr;  ///< used when solid is null; must hold the whole cube
  TileKey tile;                         ///< of the block
  /// True: direction and tangential curvature of the solid's gradient come from its distances, which are linear beside
  /// a plane, not from its densities, whose stencil misses the normal of a tilted plane by up to 0.02. Only for solids
  /// whose distances are also exact beyond the ramp.
  bool by_distances = false;
};

/// Sum of the distances to the surfaces of two solids at x, [m]; both sides must have a solid.
inline double gap_between(const CubeSide& a, const CubeSide& b, const Vec3& x) {
  return a.solid->rough_distance(a.pose.to_local(x)) + b.solid->rough_distance(b.pose.to_local(x));
}

/// The nodes lo <= (i, j, k) <= hi.
struct NodeBox {
  Vec3i lo, hi;
};

/// The contacts that a search has found so far, in its order, and its cost.
struct CubeFinds {
  std::vector<Contact> contacts;
  std::vector<NodeBox> boxes;  ///< own nodes searched, of each cube in which both parts were sampled
  std::int64_t engulfed = 0;   ///< overlapping nodes without any gradient
  std::int64_t nodes = 0;      ///< nodes sampled of solids, counted per part
  void clear() {
    contacts.clear(), boxes.clear();
    engulfed = nodes = 0;
  }
};

/// Largest sum of the distances to two surfaces, divided by the ramp width, at which ρ_a + ρ_b may exceed 1 − margin:
/// for a given sum t w, ρ_a + ρ_b is largest where one of the two is 0 or 1, and is then 1 − (3 t² − 2 t³).
double widest_gap(double margin);

/// Finds the contacts at the nodes of a box of at most 6x6x6. The cheaper part is sampled first, the other where the
/// first leaves room for contact, then both around the contacts; nodes that no stencil reads are not sampled. Tests:
/// tests/contact/cube_contacts_test.cpp
void find_in_cube(const CubeSide& a, const CubeSide& b, const ContactPair& pair, const NodeBox& box, CubeFinds& finds);

/// The same at all nodes of a tile's octants; a side that is a block must be the block of that tile.
void find_in_tile(const CubeSide& a, const CubeSide& b, const ContactPair& pair, const TileKey& tile, Octants octants,
                  CubeFinds& finds);

/// Finds the contacts of two solids at all nodes of a box. The box is halved until a piece fits into a cube or the
/// distances at its centre c exclude contact: d_a(c) + d_b(c) > 2 R + widest gap, R: radius of the piece.
void find_between_solids(const CubeSide& a, const CubeSide& b, const ContactPair& pair, const NodeBox& box,
                         CubeFinds& finds);

/// A piece of a pair's search; pieces are listed in the order of the contacts.
struct PairFinds {
  std::size_t pair = 0;  ///< index into ContactSet::pairs
  const CubeFinds* finds = nullptr;
};
/// Collects the contacts found into a set; `set.pairs` holds the pairs on entry. @param pieces  ordered by pair
void gather(std::span<const PairFinds> pieces, ContactSet& set);

}  // namespace brim
