#include "brim/scene/limits.h"

#include <cmath>

#include "brim/grid/tile.h"

namespace brim {

void check_count(const Node& n, double count, double bytes, double limit, const char* what) {
  if (count * bytes > limit)
    throw n.error(fmt::format("{} would make about {:.3g} {}, {:.3g} bytes; memory_limit allows {:.3g}",
                              shown(n.json()), count, what, count * bytes, limit));
}

void check_voxel_size(const Node& body, double h, double area, double limit) {
  if (!(h > 0.0))
    throw body.error(
        "the shape is flat: no voxel_size follows from a thickness of 0 m; give \"voxel_size\", or for a mesh of a "
        "sheet "
        "treatment \"thickness\" with a \"thickness\"");
  const double side = kTileSize * h;
  const double tiles = area / (side * side);
  const double bytes = tiles * (sizeof(TileKey) + sizeof(DensityBlock) / 16.0);
  if (!(bytes > limit)) return;
  const double allowed = h * std::sqrt(bytes / limit);
  const Node at = body.number("voxel_size") > 0.0 ? body.at("voxel_size") : body;
  throw at.error(
      fmt::format("a voxel_size of {:.3g} m on {:.3g} m² of surface would need about {:.3g} bytes; memory_limit "
                  "allows {:.3g}, a voxel_size of at least {:.2g}",
                  h, area, bytes, limit, allowed));
}

}  // namespace brim
