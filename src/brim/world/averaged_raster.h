#pragma once

#include <span>

#include "brim/body/body.h"

namespace brim {

/// Resolution at which a part is rasterized.
struct CoarseStep {
  double h = 0.0;     ///< [m] step of the tiles
  double ramp = 3.0;  ///< [steps] ramp width
  int level = 0;      ///< number of doublings of the step
};

/// As Body::rasterize, at a level of detail: the part's density is computed in steps of h / 2^level and reduced level
/// by level (reduce_tiles). Time and memory are those of the fine steps.
void rasterize_averaged(const Body& body, int part, const CoarseStep& step, std::span<const TileKey> tiles,
                        std::span<DensityBlock> out);

}  // namespace brim
