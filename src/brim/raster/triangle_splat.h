#pragma once

#include <cstdint>

#include "brim/grid/tile.h"
#include "brim/math/types.h"

namespace brim {

/// Nearest triangle of each node of a block: lowers distance2 and sets nearest where a triangle comes closer than
/// what is there; of equals the first stays.
/// @param reach   [m]  triangles farther than this from a node need not be looked at
/// @param wanted  the octants of the block that count
void splat_triangle(const Vec3& a, const Vec3& b, const Vec3& c, std::int32_t id, double reach, const Vec3& origin,
                    double h, Octants wanted, double* distance2, std::int32_t* nearest);

}  // namespace brim
