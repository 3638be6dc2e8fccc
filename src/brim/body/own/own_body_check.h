#pragma once

#include <string>
#include <vector>

#include "brim/body/own/own_body.h"

namespace brim {

/// Holds the functions of an own body against each other, at its start and at random coordinates near it (each moves
/// matter by at most 2 % of the extent), for authors; `brim validate` and brim.check call it:
///   energy_force   −∂E/∂q by differences, to 1 % of the largest force
///   jacobian       ∂deform/∂q by differences, to 1 % of the motion by that coordinate
///   inverse_deform inverse_deform(deform(X)) = X, to 1 % of the extent
///   distance       0 on the vertices of the surface and negative at its matter, to a quarter of a voxel; positive a
///   voxel
///                  outside; growing by 1 per metre outwards within half a ramp, to 20 % (medians over triangles)
///   mass           symmetric and positive (apply_mass); every coordinate has an effect of its own (lost_coordinates)
/// A function that is called for differences alone is not asked for what it cannot get wrong. All must give finite
/// values.
/// @param body  updated once at least: added to a world
/// @return one sentence for each function that is wrong, with body, coordinate or place, value and what is allowed
/// Tests: tests/body/own_body_check_test.cpp
std::vector<std::string> check_own_body(const OwnBody& body, unsigned seed = 1);

}  // namespace brim
