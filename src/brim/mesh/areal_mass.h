#pragma once

#include "brim/math/types.h"

namespace brim {

/// Areal mass of a scan's surface, [kg/m²], for the choice of contact stiffness.
///   6 m / A             for solids: the length of a box, twice the radius of a ball
///   6 (m/V) Vb / Ab     for wires and sheets, b: bounding box. They touch with a fraction of their outline, on average
///                       the volume fraction (Delesse), under the load of a full outline
/// Thickness 6 V / A below three voxels, the width of the ramp, counts as wires, from six voxels on as solid; in
/// between the two formulas are blended.
/// @param mass, volume  [kg], [m³] m and V  @param surface  [m²] A  @param h  [m] voxel size of contact
/// Tests: tests/mesh/areal_mass_test.cpp
double areal_mass(double mass, double volume, double surface, const Aabb& box, double h);

}  // namespace brim
