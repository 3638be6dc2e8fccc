#pragma once

#include <memory>

#include "brim/mesh/distance_grid.h"
#include "brim/raster/shape.h"

namespace brim {

/// Solid given by sampled signed distances, from closed, open or defective meshes (paper, section 5.3: a precomputed
/// field).
/// @param thickness  [m] smallest extent of the solid, for warnings
std::shared_ptr<const Shape> make_grid_shape(std::shared_ptr<const DistanceGrid> grid, double thickness);

}  // namespace brim
