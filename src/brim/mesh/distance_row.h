#pragma once

#include "brim/mesh/distance_grid.h"

namespace brim {

/// grid.value() in single precision at start + i step for every bit i of `wanted`, 0 to 7; other entries are left
/// alone. Some 10 ns a value in cells that have all of their 64 nodes.  Tests: tests/mesh/distance_row_test.cpp
void distance_row(const DistanceGrid& grid, const Vec3& start, const Vec3& step, std::uint8_t wanted, float* out);

}  // namespace brim
