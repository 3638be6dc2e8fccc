#include "brim/world/averaged_raster.h"

#include <algorithm>
#include <vector>

#include "brim/raster/tile_pyramid.h"

namespace brim {

void rasterize_averaged(const Body& body, int part, const CoarseStep& step, std::span<const TileKey> tiles,
                        std::span<DensityBlock> out) {
  if (step.level == 0) return body.rasterize(part, step.h, step.ramp * step.h, tiles, out);
  const CoarseStep fine{0.5 * step.h, step.ramp, step.level - 1};
  std::vector<TileKey> wanted = tiles_below(tiles), present, below;
  Aabb region;
  for (const TileKey& t : wanted) region.extend(tile_box(t, fine.h));
  body.presence(part, fine.h, fine.ramp * fine.h, region.inflated(fine.h), present);
  sort_unique(present);
  std::set_intersection(wanted.begin(), wanted.end(), present.begin(), present.end(), std::back_inserter(below));
  std::vector<DensityBlock> blocks(below.size());
  if (!below.empty()) rasterize_averaged(body, part, fine, below, blocks);
  reduce_tiles(below, blocks, tiles, out);
}

}  // namespace brim
