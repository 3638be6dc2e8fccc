#pragma once

#include <span>

#include "brim/body/body.h"

namespace brim {

/// How a part is to be seen.
struct CoarseStep {
  double h = 0.0;     ///< [m] step of the tiles
  double ramp = 3.0;  ///< [steps] ramp width
  int level = 0;      ///< how many times the step was doubled
};

/// As Body::rasterize, at a level of detail: the part's density in steps of h / 2^level, reduced level by level
/// (reduce_tiles). Costs as much as those, in time and memory.
void rasterize_averaged(const Body& body, int part, const CoarseStep& step, std::span<const TileKey> tiles,
                        std::span<DensityBlock> out);

}  // namespace brim
