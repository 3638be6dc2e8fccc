#pragma once

#include <functional>
#include <vector>

#include "brim/math/types.h"

namespace brim {

/// Particles of a fluid at its start.
struct FluidLattice {
  std::vector<Vec3> x;   ///< [m]
  double spacing = 0.0;  ///< [m] cube root of the volume of a particle
};

/// Centres of the cells of a lattice that fits a box: L/n wide along each axis, n the whole number nearest to L/spacing
/// and at least 1, so that the outermost particles lie half a cell from the faces and the particles' volumes add up to
/// the box. A box of whole numbers of spacings has cubes of `spacing`, exactly.
/// @param spacing  [m] asked for, > 0  Tests: tests/body/fluid_lattice_test.cpp
FluidLattice lattice_in_box(const Vec3& lo, const Vec3& hi, double spacing);

/// Fills a solid with the lattice of its bounding box: of the cells whose centre lies inside, in order of depth, as
/// many as its volume asks for, those of equal depth together. The lattice is then stretched about the middle of the
/// box by the cube root of what is still missing:
///   spacing³ N = volume, exactly
/// @param distance  [m] to the solid's surface, negative inside  @param volume  [m³] of the solid
/// A solid that fills its bounding box gets lattice_in_box. No particles when no centre lies inside.
FluidLattice lattice_in_solid(const std::function<double(const Vec3&)>& distance, const Aabb& box, double volume,
                              double spacing);

}  // namespace brim
