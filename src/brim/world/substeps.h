#pragma once

#include <memory>
#include <span>
#include <vector>

#include "brim/world/contact_stage.h"

namespace brim {

/// Length of the next sub-step, [s]: `left` cut into equal pieces so that no two parts that can meet in the remaining
/// time move by more than max_motion_voxels of their common step relative to each other in one piece (a CFL rule).
double choose_substep(std::span<const WorldPart> parts, std::span<const std::unique_ptr<Body>> bodies,
                      std::span<const double> v, std::span<const std::size_t> first_v, const WorldOptions& options,
                      double left, StepReport& report);

}  // namespace brim
