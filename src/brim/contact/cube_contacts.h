#pragma once

#include <vector>

#include "brim/contact/contact_set.h"
#include "brim/grid/node_cube.h"
#include "brim/raster/known_distance.h"

namespace brim {

/// Where the densities of one part come from, for cubes: a solid that is sampled as wanted, or the block of a tile.
struct CubeSide {
  const KnownDistance* solid = nullptr;
  Pose pose;                            ///< of the solid
  const DensityBlock* block = nullptr;  ///< where there is no solid; must hold the whole cube
  TileKey tile;                         ///< of the block
  /// Contacts take the direction and the bend of the solid's gradient from its distances, which are linear beside a
  /// plane, and not from its densities, of which the stencil misses the normal of a tilted plane by up to 0.02. Only of
  /// solids whose distances are right beyond the ramp as well.
  bool by_distances = false;
};

/// Distance to the surface of one solid and to that of another, together, [m]; both sides have solids.
inline double gap_between(const CubeSide& a, const CubeSide& b, const Vec3& x) {
  return a.solid->rough_distance(a.pose.to_local(x)) + b.solid->rough_distance(b.pose.to_local(x));
}

/// The nodes lo <= (i, j, k) <= hi.
struct NodeBox {
  Vec3i lo, hi;
};

/// The contacts that a search has found so far, in its order, and what it has cost.
struct CubeFinds {
  std::vector<Contact> contacts;
  std::vector<NodeBox> boxes;  ///< of the cubes in which both parts were sampled, their own nodes that were looked at
  std::int64_t engulfed = 0;   ///< overlapping nodes without any gradient
  std::int64_t nodes = 0;      ///< sampled of solids, counted per part
  void clear() {
    contacts.clear(), boxes.clear();
    engulfed = nodes = 0;
  }
};

/// Largest sum of the distances to two surfaces, over the ramp width, at which ρ_a + ρ_b may pass 1 − margin: at a
/// given sum t w the densities' sum is largest where one of them is 0 or 1, and is then 1 − (3 t² − 2 t³).
double widest_gap(double margin);

/// Finds the contacts at the nodes of a box of at most 6x6x6. The part that costs less is sampled first, the other
/// where the first leaves room, and both around what touches: nodes that no stencil reads are not sampled. Tests:
/// tests/contact/cube_contacts_test.cpp
void find_in_cube(const CubeSide& a, const CubeSide& b, const ContactPair& pair, const NodeBox& box, CubeFinds& finds);

/// The same at all own nodes of the octants of a tile; a side that is a block must be that tile's.
void find_in_tile(const CubeSide& a, const CubeSide& b, const ContactPair& pair, const TileKey& tile, Octants octants,
                  CubeFinds& finds);

/// Finds the contacts of two solids at all nodes of a box. It is halved until the distances at a
/// centre rule a piece out, d_a(c) + d_b(c) > 2 R + widest gap with R the piece's radius, or it fits into a cube.
void find_between_solids(const CubeSide& a, const CubeSide& b, const ContactPair& pair, const NodeBox& box,
                         CubeFinds& finds);

/// A piece of a pair's search, in the order in which contacts are wanted.
struct PairFinds {
  std::size_t pair = 0;  ///< index into ContactSet::pairs
  const CubeFinds* finds = nullptr;
};
/// Puts what has been found into a set; `set.pairs` holds the pairs on entry. @param pieces  ordered by pair
void gather(std::span<const PairFinds> pieces, ContactSet& set);

}  // namespace brim
