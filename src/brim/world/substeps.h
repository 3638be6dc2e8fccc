#pragma once

#include <memory>
#include <span>
#include <vector>

#include "brim/math/box_sweep.h"
#include "brim/world/contact_stage.h"

namespace brim {

/// [m] by which two parts may move relative to each other in one sub-step: max_motion_voxels of their common step, and
/// up to twice that (but no more than two voxels) where both together are thick and forces hold them apart, by a
/// quarter of their thickness, as what is thick cannot be passed in a step. Not where rows hold two rigid parts.
double motion_limit(const WorldPart& a, const WorldPart& b, const WorldOptions& options);

/// Pieces, at least 1, that `time` [s] must be cut into so that no two parts that can meet in it move by more than
/// motion_limit relative to each other in one piece (a CFL rule).
/// Parts that deform are looked at cluster by cluster (MotionClusters).
/// @param v       velocities of all bodies, that of body b from first_v[b] on
/// @param change  [m/s] what the velocities may gain in that time
/// @param sweep   workspace, best the same from step to step
double motion_pieces(std::span<const WorldPart> parts, std::span<const double> v, std::span<const std::size_t> first_v,
                     const WorldOptions& options, double time, double change, BoxSweep& sweep);

/// Length of the next sub-step, [s]: `left` cut into equal pieces. @param pieces  that motion asks for
double choose_substep(double pieces, const WorldOptions& options, double left, StepReport& report);

}  // namespace brim
