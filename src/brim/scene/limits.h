#pragma once

#include "brim/scene/node.h"

namespace brim {

/// Throws when the elements of a mesh to be made would exceed the memory limit of the world.
/// @param n          the value that determines their number
/// @param count      number of elements
/// @param bytes      [bytes] per element, with all data of a step
/// @param limit      [bytes] memory_limit of the scene
/// @throws InputError
void check_count(const Node& n, double count, double bytes, double limit, const char* what);

/// Throws when voxels of step h on a surface would exceed the memory limit. Counts one in sixteen of the tiles that the
/// surface meets: contact rasterizes only where bodies meet.
/// @param area  [m²] of the surface
/// @throws InputError  at the body's voxel_size
void check_voxel_size(const Node& body, double h, double area, double limit);

}  // namespace brim
