#pragma once

#include <vector>

#include "brim/raster/tile_cover.h"

namespace brim {

/// Optional interface of bodies that know in which octants of tiles a part may hold density. The world then samples the
/// part, and parts it meets, only there; for other bodies it uses whole tiles.
class OctantPresence {
 public:
  virtual ~OctantPresence() = default;
  /// As Body::presence, for octants that may hold density at their own nodes within the region; none may be missing.
  /// @param out  appended to; order and repetition do not matter
  virtual void octant_presence(int part, double h, double w, const Aabb& region,
                               std::vector<OctantTile>& out) const = 0;
};

}  // namespace brim
