#pragma once

#include <vector>

#include "brim/raster/tile_cover.h"

namespace brim {

/// What a Body may be besides where it can say in which octants of tiles a part may hold density. The world then
/// samples the part, and what it meets, only there; of other bodies it takes whole tiles.
class OctantPresence {
 public:
  virtual ~OctantPresence() = default;
  /// As Body::presence, of octants that may hold density at their own nodes within the region: never too few.
  /// @param out  appended to; order and repetition do not matter
  virtual void octant_presence(int part, double h, double w, const Aabb& region,
                               std::vector<OctantTile>& out) const = 0;
};

}  // namespace brim
