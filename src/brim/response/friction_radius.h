#pragma once

#include <functional>
#include <span>

#include "brim/math/types.h"
#include "brim/response/moved_rows.h"

namespace brim {

/// Places the friction points of a flat patch so that their torque about the normal is that of a uniform pressure over
/// the patch: on the line from the patch's centroid to each corner, at the share
///   κ = ∫ r dA / (A r̄),  r: distance from the centroid, r̄: its mean over the corners
/// 2/3 for a disc, 0.541 for a square, 1/2 for a segment. (With friction at the corners themselves the torque would be
/// half as large again.) Corners on a round rim stand for more area than their polygon.
/// @param corners  [m] of a convex patch, at least two, in any order; their grips are set
/// @param normal   unit
/// @param rim      distance from a centre to the patch's rim in a tangential direction, or 0 where unknown; may be
///                 empty
/// Tests: tests/response/friction_radius_test.cpp
void place_grips(std::span<RowPoint> corners, const Vec3& normal,
                 const std::function<double(const Vec3& center, const Vec3& way)>& rim);

}  // namespace brim
