#pragma once

#include <optional>
#include <span>
#include <string>

#include "brim/world/world_part.h"

namespace brim {

/// What cannot be right of fluids on grids (FlowsAround), in words; nothing where all is well.
/// Tests: tests/world/fluid_warnings_test.cpp

/// A fluid faster than sound in water: an incompressible one has then no way out between its solids.
/// @param v, first_v  velocities of all bodies, and where each body's begin
std::optional<std::string> runaway_fluid(std::span<const WorldPart> parts, std::span<const double> v,
                                         std::span<const std::size_t> first_v);

/// Two fluids that may touch and whose boxes overlap: their contact gains energy.
std::optional<std::string> meeting_fluids(std::span<const WorldPart> parts);

}  // namespace brim
