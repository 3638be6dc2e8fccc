#pragma once

#include <span>

#include "brim/world/contact_parameters.h"
#include "brim/world/step_report.h"
#include "brim/world/world_part.h"

namespace brim {

/// Rolling resistance of rigid bodies: the load N of a contact acts ahead of its centre, by at most b, the pair's
/// rolling_resistance [m] (Hibbeler, Statics, "Rolling Resistance"). After a sub-step's solve each such pair gets the
/// impulses of a torque T, opposite on both, and of a force P at its centre of pressure x:
///   w⁺ = w + C T = 0,   |T| <= b N dt,   C = Δw per T where P leaves the velocity at x unchanged
/// with w the relative spin tangential to the surface. P is the static friction that results as the torque slows the
/// rolling body; if friction is exhausted (|F + P/dt| > μ N, F: friction found by the solve), P = 0 and C = I_a⁻¹ +
/// I_b⁻¹. Pairs are handled one after another in the order of the report, so that a body with several contacts is
/// slowed by each; the next sub-step corrects the rest. Momentum and angular momentum are conserved exactly.
/// Only between rigid bodies, or one and a fixed part (RigidFrame); grains have a resistance of their own.
/// @param pairs  of this sub-step, with their forces
/// @param v      [m/s] before the sub-step  @param delta  [m/s] solved velocity change, modified here
/// Tests: tests/world/rolling_resistance_test.cpp
void resist_rolling(std::span<const WorldPart> parts, std::span<const std::size_t> first_v,
                    std::span<const PairReport> pairs, const ContactParameters& laws, const WorldOptions& options,
                    double dt, std::span<const double> v, std::span<double> delta);

}  // namespace brim
