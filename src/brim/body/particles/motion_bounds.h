#pragma once

#include <cstdint>
#include <span>

#include "brim/body/motion_clusters.h"

namespace brim {

/// Bounds of the position and velocity of some particles.
/// @param x, v   [m], [m/s] of all particles of the body; when v holds more than three numbers each, such as spins, the
///               first three are the velocity
/// @param nodes  indices of the particles, at least one  @param reach  [m] of their matter
MotionCluster motion_bounds(std::span<const Vec3> x, std::span<const double> v, std::span<const std::int32_t> nodes,
                            double reach);

}  // namespace brim
