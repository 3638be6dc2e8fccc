#pragma once

#include <span>

#include "brim/math/types.h"

namespace brim {

/// Loads on the points of a flat contact are not determined by the motion where there are more than three: two rigid
/// faces bear each other on any of them. Of all loads with the same sum and the same centre, the most even ones, which
/// have the least sum of squares, are those of a thin elastic layer between the faces: N = α + β·x. So friction of a
/// face that slides and spins has no preferred side.
/// @param points  [m]  @param normal  unit, common to all  @param load  >= 0, changed in place; shape (points)
/// @return false when the loads stay as they are: fewer than four points, points on a line, or no load
/// Tests: tests/response/even_loads_test.cpp
bool even_loads(std::span<const Vec3> points, const Vec3& normal, std::span<double> load);

}  // namespace brim
