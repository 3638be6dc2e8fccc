#pragma once

#include <memory>

#include "brim/mesh/occupancy.h"
#include "brim/raster/shape.h"

namespace brim {

/// A rigid solid given by an image (paper, section 5.3: raw data projected to the grid): rho = volume fraction of a
/// ball (BallField), sampled under the pose. No surface is built. Tiles are found from a coarse mask of the matter. A
/// field is built for each ramp width on its first request.
/// @param thickness  [m] smallest extent of the solid, for warnings
/// Tests: tests/raster/image_shape_test.cpp
std::shared_ptr<const Shape> make_image_shape(OccupancyGrid grid, double thickness);

}  // namespace brim
