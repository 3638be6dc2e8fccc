#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "brim/math/box_sweep.h"
#include "brim/world/contact_stage.h"
#include "brim/world/held_pairs.h"

namespace brim {

/// [m] largest relative motion of two parts in one sub-step: max_motion_voxels of their common step. It rises with
/// their combined thickness, by a quarter of it, up to twice that value (at most two voxels), as a thick part cannot be
/// passed in a step. Not for conforming parts, nor for two rigid parts that rows hold already: along them they turn and
/// slide.
/// @param held  rows connected the two in the last sub-step
double motion_limit(const WorldPart& a, const WorldPart& b, const WorldOptions& options, bool held);

/// Motion along a half-space: it meets the same surface, however far it goes.
enum class AlongPlanes : std::uint8_t { Ignored, Counted };

/// Number of pieces, at least 1, into which `time` [s] must be cut so that no two parts that can meet in it exceed
/// motion_limit in one piece (a CFL rule).
/// Deformable parts are examined cluster by cluster (MotionClusters).
/// @param v       velocities of all bodies, that of body b from first_v[b] on
/// @param change  [m/s] possible gain of the velocities in that time
/// @param held    pairs that rows connected in the last sub-step
/// @param sweep   workspace, preferably the same from step to step
/// @param along   what counts of the motion relative to half-spaces that do not turn
double motion_pieces(std::span<const WorldPart> parts, std::span<const double> v, std::span<const std::size_t> first_v,
                     const WorldOptions& options, double time, double change, const HeldPairs& held, BoxSweep& sweep,
                     AlongPlanes along = AlongPlanes::Ignored);

/// The same for what a solve has changed the velocities by, motion along planes included: a body that a wedge of two
/// planes squeezes out leaves along both. 1 where there are no half-spaces.
/// @param change  of all velocities, [m/s, rad/s]
double thrown_pieces(std::span<const WorldPart> parts, std::span<const double> change,
                     std::span<const std::size_t> first_v, const WorldOptions& options, double time,
                     const HeldPairs& held, BoxSweep& sweep);

/// Pieces, at least 1, that `time` [s] must be cut into so that the balls of a body of balls (SpinningBalls) fall by at
/// most 0.16 of the least radius in one piece, g dt² <= 0.16 R. With longer ones heaps do not come to rest.
/// @param gravity  [m/s²] its size
double fall_pieces(std::span<const WorldPart> parts, double gravity, double time);

/// Pieces, at least 1, that `time` [s] must be cut into for the inner forces of all bodies (LongestStep).
double stable_pieces(std::span<const WorldPart> parts, double time);

/// Pieces that the rest of a step must be cut into.
struct NeededPieces {
  double motion = 1.0;  ///< motion_pieces
  double fall = 1.0;    ///< fall_pieces
  double inner = 1.0;   ///< stable_pieces
  double swing = 1.0;   ///< Links::swing_pieces
  double spin = 1.0;    ///< Links::spin_pieces
};

/// Length of the next sub-step, [s]: `left` cut into equal pieces. Warns where these are more than max_substeps allows.
double choose_substep(const NeededPieces& needed, std::span<const WorldPart> parts, std::span<const double> v,
                      std::span<const std::size_t> first_v, const WorldOptions& options, double left,
                      StepReport& report);

}  // namespace brim
