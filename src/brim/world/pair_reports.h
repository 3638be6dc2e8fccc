#pragma once

#include <span>
#include <vector>

#include "brim/contact/contact_set.h"
#include "brim/world/contact_parameters.h"
#include "brim/world/contact_stage.h"

namespace brim {

/// Warns of pairs that overlap deeply in the first step.
void warn_of_start(std::span<const WorldPart> parts, double time, StepReport& report);

/// Warns of loaded pairs under rows with a mass ratio of 300 and more, when the light body carries more than ten times
/// its own weight: called when the rows of a step did not converge.
void warn_of_mass_ratio(std::span<const WorldPart> parts, const ContactParameters& laws, const WorldOptions& options,
                        double time, StepReport& report);

/// Writes the totals of every touching pair, the contact samples, and the warnings of nearly saturated contacts.
/// @param parameters  of each pair of contacts
void report_pairs(std::span<const WorldPart> parts, const ContactSet& contacts, std::span<const PairState> parameters,
                  std::span<const Vec3> normal, std::span<const Vec3> friction, double time, StepReport& report,
                  std::vector<ContactSample>& samples);

/// Adds the impulses of all pairs over a sub-step to those of the bodies.
void add_impulses(std::span<const WorldPart> parts, std::size_t bodies, double dt, StepReport& report);

/// The warning of a pair whose densities saturate, if they do. @param stiffness  [Pa] of penalties, 0 under rows
void warn_of_saturation(std::span<const WorldPart> parts, const PairReport& pair, double stiffness, double time,
                        StepReport& report);

}  // namespace brim
