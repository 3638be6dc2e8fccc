#pragma once

#include <memory>
#include <span>
#include <vector>

#include "brim/math/box_sweep.h"
#include "brim/world/contact_stage.h"

namespace brim {

/// [m] largest relative motion of two parts in one sub-step: max_motion_voxels of their common step. For pairs kept
/// apart by forces it rises with their combined thickness, by a quarter of it, up to twice that value (at most two
/// voxels), as a thick part cannot be passed in a step. Not for two rigid parts held by rows, nor for conforming parts.
double motion_limit(const WorldPart& a, const WorldPart& b, const WorldOptions& options);

/// Number of pieces, at least 1, into which `time` [s] must be cut so that no two parts that can meet in it exceed
/// motion_limit in one piece (a CFL rule).
/// Deformable parts are examined cluster by cluster (MotionClusters).
/// @param v       velocities of all bodies, that of body b from first_v[b] on
/// @param change  [m/s] possible gain of the velocities in that time
/// @param sweep   workspace, preferably the same from step to step
double motion_pieces(std::span<const WorldPart> parts, std::span<const double> v, std::span<const std::size_t> first_v,
                     const WorldOptions& options, double time, double change, BoxSweep& sweep);

/// Length of the next sub-step, [s]: `left` cut into equal pieces. @param pieces  required by motion
double choose_substep(double pieces, const WorldOptions& options, double left, StepReport& report);

}  // namespace brim
