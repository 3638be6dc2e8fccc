#pragma once

#include "brim/scene/node.h"

namespace brim {

/// Throws when elements of a mesh yet to be made would not fit into the memory limit of the world.
/// @param n          the value that decides their number
/// @param count      how many there would be
/// @param bytes      [bytes] each, with all that the step needs of it
/// @param limit      [bytes] memory_limit of the scene
/// @throws InputError
void check_count(const Node& n, double count, double bytes, double limit, const char* what);

/// Throws when voxels of step h on a surface would not fit into the memory limit. Only the tiles that the surface
/// meets count, and of those only one in sixteen: contact rasterizes where bodies meet.
/// @param area  [m²] of the surface
/// @throws InputError  at the body's voxel_size
void check_voxel_size(const Node& body, double h, double area, double limit);

}  // namespace brim
