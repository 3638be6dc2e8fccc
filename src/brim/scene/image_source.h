#pragma once

#include "brim/mesh/occupancy.h"
#include "brim/scene/node.h"

namespace brim {

/// Checks of a body's image source that the schema cannot express; reads no files. @throws InputError
void check_image_source(const Node& body);

/// The image of a body ("file" with "window", "raw", "unit", or "shape" with "image_spacing") as matter in cells,
/// scaled, centred and freed of small pieces as the body requests.
struct ImageSolid {
  OccupancyGrid grid;       ///< [m] in the body's frame
  double voxel_size = 0.0;  ///< [m] as given, or a 48th of the image's longest extent
  /// If the body gives tables by intensity, else empty: means over each whole cell of the filled fraction times the
  /// material quantity; shape (cells).
  std::vector<float> density;  ///< [kg/m³]
  std::vector<float> young;    ///< [Pa]
};

/// @param scale           [-] of all lengths
/// @param cells_per_voxel cells along a voxel of contact
/// @param memory_limit    [bytes] of the scene
/// @param finest          [m] smallest voxel of contact, from the world's voxel_size; 0: any
/// @throws InputError
ImageSolid read_image_solid(const Node& body, double scale, double cells_per_voxel, double memory_limit,
                            double finest = 0.0);

}  // namespace brim
