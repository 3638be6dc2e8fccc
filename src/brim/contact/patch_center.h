#pragma once

#include <span>

#include "brim/contact/cube_contacts.h"

namespace brim {

/// Centres the points of a curved patch between two solids on the place of the least gap. Where a ball meets a plane a
/// few nodes carry it, and the centre of their overlap is off the place of touch by some tenths of a voxel, now on this
/// side and now on that: a lever that brakes and drives what rolls. The distances know the place,
///   gap(x̄ + t) = gap + g·t + ½ t·H t,   t = −H⁻¹ g     (x̄: centre of the overlap; differences over half a voxel and
///   one)
/// and all points move by t, in the directions in which the gap is a parabola there and the patch no wider than a few
/// voxels; along a line of contact, on faces and at edges they stay. Those that have moved are carried along the normal
/// onto the surface of the part that moves: friction there turns it by its own radius, and what rolls on a surface into
/// which it sinks by δ does not roll as if it were smaller by half of that.
/// @param moving  a or b: the other is fixed
/// @param h       [m] step of the grid
/// Tests: tests/contact/patch_center_test.cpp
void center_on_least_gap(const CubeSide& a, const CubeSide& b, const CubeSide& moving, double h,
                         std::span<Contact> contacts);

/// How round two solids are in the middle of where they touch: 0 where the gap is level, as between faces, or has a
/// kink, as at an edge; towards 1 where it is a parabola, as under a ball. 1 where there is no contact.
/// @param h  [m] step of the grid
double roundness(const CubeSide& a, const CubeSide& b, double h, std::span<const Contact> contacts);

}  // namespace brim
