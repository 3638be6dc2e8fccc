#pragma once

#include <span>
#include <vector>

#include "brim/world/contact_stage.h"
#include "brim/world/world_part.h"

namespace brim {

/// Factors on gravity for solids that only links hold. They move by x ← x + dt v⁺, so v⁺ is their velocity half a
/// sub-step before the end, as in the leapfrog method: between two such velocities gravity acts for the mean of both
/// sub-steps, (dt₀ + dt)/2. With dt alone a swing whose sub-steps are shorter where it is fast would lose energy at
/// every change of length. Solids that touch anything else, directly or by others, have a factor of 1: contact balances
/// their weight.  Tests: tests/world/links_swing_test.cpp
/// @param before  [s] dt₀, length of the sub-step before; 0: there was none, all have 1
/// @param given   factors on gravity per body; those beyond its end have 1
/// @param factor  the product of both, per body
void leapfrog_gravity(std::span<const WorldPart> parts, const ContactStage& stage, std::size_t bodies, double before,
                      double dt, std::span<const double> given, std::vector<double>& factor);

}  // namespace brim
