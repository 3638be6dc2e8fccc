#pragma once

#include <memory>

#include "brim/mesh/occupancy.h"
#include "brim/raster/shape.h"

namespace brim {

/// A rigid solid given by an image (paper, section 5.3: raw data projected to the grid): rho = share of matter in a
/// ball (BallField), sampled under the pose. No surface is made. Tiles are found from a coarse mask of where matter is.
/// A field is made for each ramp width that is asked for, the first time.
/// @param thickness  [m] smallest extent of the solid, for warnings
/// Tests: tests/raster/image_shape_test.cpp
std::shared_ptr<const Shape> make_image_shape(OccupancyGrid grid, double thickness);

}  // namespace brim
