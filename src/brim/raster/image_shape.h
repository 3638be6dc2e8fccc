#pragma once

#include <memory>

#include "brim/mesh/distance_grid.h"
#include "brim/mesh/occupancy.h"
#include "brim/raster/shape.h"

namespace brim {

/// The signed distance of the matter of an image, sampled at the centres of its cells (paper, section 5.3: raw data as
/// a precomputed field). The surface is where a ball of four cells' diameter is half full (BallField), which smooths
/// the cells away and leaves flat surfaces where they are. Matter too thin to fill a ball to a half is kept where its
/// cells are filled to a quarter or more.
/// @throws InputError  when there is no matter
/// Same bits for any number of threads.  Tests: tests/raster/image_shape_test.cpp
DistanceGrid distance_of_matter(const OccupancyGrid& matter);

/// A rigid solid given by an image. @param thickness  [m] smallest extent of the solid, for warnings
std::shared_ptr<const Shape> make_image_shape(const OccupancyGrid& matter, double thickness);

}  // namespace brim
