#pragma once

#include "brim/body/distance_bound.h"
#include "brim/contact/contact_set.h"
#include "brim/grid/tile.h"

namespace brim {

/// A part and its distance bound; null when it has none.
struct BoundedPart {
  const DistanceBound* body = nullptr;
  int part = 0;
};

/// The octants of a tile in which some node may be a contact of the two parts. An octant is culled where the sum of the
/// distances to their surfaces is too large: the sum changes by at most twice the distance moved, so
///   d_a(c) + d_b(c) > 2 R + g  at the centre c of a cube of nodes of radius R
/// excludes the whole cube, g: largest sum at which ρ_a + ρ_b > 1 − margin (for a given sum t w, ρ_a + ρ_b is largest
/// where one of them is 0 or 1, and is then 1 − (3 t² − 2 t³)). If only one part has a distance bound, its density must
/// reach into the cube: d(c) <= R + w/2. The test is applied to the whole tile, then its octants, then cubes of two
/// nodes a side. Tests: tests/world/tile_culling_test.cpp
Octants octants_with_room(const BoundedPart& a, const BoundedPart& b, const ContactPair& pair, const TileKey& tile);

}  // namespace brim
