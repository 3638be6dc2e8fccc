#pragma once

#include <array>
#include <optional>

#include "brim/contact/cube_contacts.h"
#include "brim/math/types.h"

namespace brim {

/// Unit vectors along which a gap is round; zero where it is flat, or as sharp as an edge.
using RoundDirections = std::array<Vec3, 2>;

/// The principal directions across a unit normal along which the gap between two sampled solids is round at x: by their
/// own distances, as nodes may suggest a roundness that is not there.
/// @param curvature  [1/m] of the gap, roughly  @param h  [m] grid step
RoundDirections round_directions(const CubeSide& a, const CubeSide& b, const Vec3& x, const Vec3& normal,
                                 const Mat3& curvature, double h);

/// A point where the gap between two sampled solids is least along the directions in which it is round.
struct RoundGap {
  Vec3 x = Vec3::Zero();  ///< [m]
  double gap = 0.0;       ///< [m] d_a + d_b there
};

/// Moves a point along the round directions to the least gap: Newton's steps on the sum of the solids' own distances,
/// with differences over three quarters of a voxel. Nodes know that place to a tenth of a voxel only, differently
/// wherever the solids lie in the grid, and what rolls would be driven by the differences.
/// @param h  [m] grid step
/// @return nothing where the gap is not round
/// Tests: tests/response/round_gap_test.cpp
std::optional<RoundGap> settle_round_gap(const CubeSide& a, const CubeSide& b, const Vec3& x,
                                         const RoundDirections& round, double h);

/// The point where two solids with formulas for their distances are nearest, where the gap is round.
struct RoundPoint {
  Vec3 x = Vec3::Zero();                              ///< [m] half-way between the surfaces
  double gap = 0.0;                                   ///< [m]
  Vec3 normal = Vec3::UnitZ();                        ///< unit, towards a
  Mat3 bend_a = Mat3::Zero(), bend_b = Mat3::Zero();  ///< [1/m] curvatures across it, positive when convex
};

/// Newton's steps from a point near the least gap, with slopes and curvatures of the solids' own distances. Nodes know
/// the curvature of a bowl to a half of itself only, and may take a ball for flat where they are few: what rolls is
/// driven or braked by normals that do not turn with the surface.
/// @param normal  towards a, roughly  @param h  [m] grid step
/// @return nothing where the gap is not round in both directions, or a solid has no formula (KnownDistance::by_rows)
std::optional<RoundPoint> find_round_point(const CubeSide& a, const CubeSide& b, const Vec3& x, const Vec3& normal,
                                           double h);

}  // namespace brim
