#pragma once

#include <functional>
#include <span>

#include "brim/math/types.h"
#include "brim/response/moved_rows.h"

namespace brim {

/// Where friction acts at the corners of a flat patch, so that its torque about the normal is that of a pressure
/// which is even over the patch: on the way from the patch's centroid to each corner,
///   κ = ∫ r dA / (A r̄),  r the distance from the centroid, r̄ its mean over the corners
/// 2/3 for a disc, 0.541 for a square, 1/2 for a segment. (Loads at the corners alone would carry friction at the rim,
/// and a torque half as large again.) Corners of a round rim stand for more than their polygon.
/// @param corners  [m] of a convex patch, in any order; their grips are set. At least two
/// @param normal   unit
/// @param rim      distance from a centre to the patch's rim along a way across, or 0 where unknown; may be empty
/// Tests: tests/response/friction_radius_test.cpp
void place_grips(std::span<RowPoint> corners, const Vec3& normal,
                 const std::function<double(const Vec3& center, const Vec3& way)>& rim);

}  // namespace brim
