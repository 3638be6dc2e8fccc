#pragma once

#include "brim/body/distance_bound.h"
#include "brim/contact/contact_set.h"

namespace brim {

/// A part, and what bounds its distances: null where nothing does.
struct BoundedPart {
  const DistanceBound* body = nullptr;
  int part = 0;
};

/// The octants of a tile in which some node may be a contact of the two parts: not those where the distances to their
/// surfaces are too large together. Their sum changes by no more than twice the way, so
///   d_a(c) + d_b(c) > 2 R + g  at the centre c of a cube of nodes of radius R
/// rules the whole cube out, with g the largest sum at which ρ_a + ρ_b > 1 − margin: at a given sum t w the densities'
/// sum is largest where one of them is 0 or 1, and is then 1 − (3 t² − 2 t³). Where one part's distances alone are
/// bounded, its density must reach into the cube: d(c) <= R + w/2. The tile is looked at whole, then its octants, then
/// in cubes of two nodes a side. Tests: tests/world/tile_culling_test.cpp
Octants octants_with_room(const BoundedPart& a, const BoundedPart& b, const ContactPair& pair, const TileKey& tile);

}  // namespace brim
