#pragma once

#include <span>

#include "brim/contact/cube_contacts.h"

namespace brim {

/// Centres the points of a curved contact patch between two solids on the point of smallest gap. A ball on a plane is
/// carried by a few nodes, and the centre of their overlap misses the contact point by some tenths of a voxel to
/// either side: a spurious lever that brakes and drives a rolling body. The distances give the point,
///   gap(x̄ + t) = gap + g·t + ½ t·H t,   t = −H⁻¹ g     (x̄: centre of the overlap; differences over half a voxel and
///   one)
/// and all points move by t, in those directions in which the gap is a parabola and the patch at most a few voxels
/// wide; along a line of contact, on faces and at edges they stay. Moved points are then carried along the normal onto
/// the surface of the moving part: friction there acts at its own radius, whereas points half-way into the other
/// surface would make a body that sinks in by δ roll as if its radius were smaller by δ/2.
/// @param moving   a or b: the one that moves, or the rounder of two that do
/// @param carried  share of the way onto that surface: 1, or less where both move and are nearly as round
/// @param h        [m] step of the grid
/// Tests: tests/contact/patch_center_test.cpp
void center_on_least_gap(const CubeSide& a, const CubeSide& b, const CubeSide& moving, double carried, double h,
                         std::span<Contact> contacts);

/// How much more the surface of one solid is bent than that of the other where they touch, (κ₁ − κ₂)/(κ₁ + κ₂): 1 for a
/// ball on a plane, 0 for two equal balls.
double rounder(const CubeSide& one, const CubeSide& other, double h, std::span<const Contact> contacts);

/// Roundness of the contact of two solids, at its middle: 0 where the gap is level, as between faces, or has a kink, as
/// at an edge; towards 1 where it is a parabola, as under a ball. 1 without contacts.
/// @param h  [m] step of the grid
double roundness(const CubeSide& a, const CubeSide& b, double h, std::span<const Contact> contacts);

}  // namespace brim
