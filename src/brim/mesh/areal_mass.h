#pragma once

#include "brim/math/types.h"

namespace brim {

/// [kg/m²] of mass behind the surface of a scan, for the choice of contact stiffness.
///   6 m / A             of solids: the length of a box, twice the radius of a ball
///   6 (m/V) Vb / Ab     of wires and sheets, b being the box around: they touch with a share of their outline, in the
///                       mean that of volume (Delesse), and as much presses on it as if the outline were full
/// Pieces of a thickness 6 V / A of less than three voxels, the width of the ramp, count as wires, of six and more as
/// solid; between them the two go over into each other.
/// @param mass, volume  [kg], [m³] m and V  @param surface  [m²] A  @param h  [m] voxel size of contact
/// Tests: tests/mesh/areal_mass_test.cpp
double areal_mass(double mass, double volume, double surface, const Aabb& box, double h);

}  // namespace brim
