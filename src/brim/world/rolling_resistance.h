#pragma once

#include <span>

#include "brim/world/contact_parameters.h"
#include "brim/world/step_report.h"
#include "brim/world/world_part.h"

namespace brim {

/// What keeps rigid bodies from rolling for ever: the load N of a contact acts ahead of its middle, by b at most, the
/// pair's rolling_resistance [m] (Hibbeler, Statics, "Rolling Resistance"). Once a sub-step is solved, each such pair
/// gets the impulses of a torque T, opposite on both, and of a force P at its centre of pressure x:
///   w⁺ = w + C T = 0,   |T| <= b N dt,   C = Δw per T where P keeps the velocity at x as it is
/// with w the spin of one against the other along the surface. P is what static friction adds as the torque slows what
/// rolls; where it has no room for it (|F + P/dt| > μ N, F the friction that was found) there is none, and C = I_a⁻¹ +
/// I_b⁻¹. One pair after the other, as they are ordered in the report, so that a body with several contacts is slowed
/// by each; the next sub-step finds how that fits. Momentum and angular momentum are kept exactly.
/// Only between rigid bodies, and of them on what is fixed (RigidFrame); grains have a resistance of their own.
/// @param pairs  of this sub-step, with their forces
/// @param v      [m/s] before the sub-step  @param delta  [m/s] change that was solved, changed here
/// Tests: tests/world/rolling_resistance_test.cpp
void resist_rolling(std::span<const WorldPart> parts, std::span<const std::size_t> first_v,
                    std::span<const PairReport> pairs, const ContactParameters& laws, const WorldOptions& options,
                    double dt, std::span<const double> v, std::span<double> delta);

}  // namespace brim
