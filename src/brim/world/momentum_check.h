#pragma once

#include <memory>
#include <span>
#include <vector>

#include "brim/world/contact_maps.h"
#include "brim/world/step_report.h"

namespace brim {

/// Compares, per body, the generalised contact forces Jᵀ f with the sum of the nodal forces f: their resultants in all
/// rigid motions of the body. The nodal forces of a pair are equal and opposite at the same points, so this also
/// verifies the momentum balance of every pair. Errors are relative to the sum of |f| (times the extent of the contacts
/// for the torque); the worst body goes to the report.
/// @param mapped  Jᵀ f of all contacts, shape (nv)
void check_momentum(std::span<const std::unique_ptr<Body>> bodies, std::span<const std::size_t> first_v,
                    std::span<const WorldPart> parts, const ContactSet& contacts, std::span<const double> mapped,
                    std::span<const Vec3> force_on_a, StepReport& report);

}  // namespace brim
