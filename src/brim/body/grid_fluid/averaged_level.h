#pragma once

#include <span>

#include "brim/body/grid_fluid/mac_grid.h"

namespace brim {

/// Distance from a point to the level set clipped to the box of its grid, [m]; trilinear, negative inside.
double boxed_distance(const MacGrid& grid, std::span<const double> phi, const Vec3& x);

/// Distance of a fluid for contact. Solids it meets are represented by volume fractions in balls as wide as the ramp,
/// so its own density must be a volume fraction of the same ball; else the fluid would leave a gap at a solid's edges
/// and overlap on curved surfaces, or the other way round. The fraction is known for another kernel,
///   ρ̄(x) = Σ_c B(x − x_c) ramp(φ_c, 2.5 dx),   expressed as the distance d̄ at which a plane has this density,
/// with B the cubic B-spline over 4x4x4 cells and φ_c the distance at their centres; for cells beyond the box at least
/// the distance to the box. The plane is averaged over its position relative to the cells; any single one is off by
/// 0.02 dx within a cell of it. The effect of a kernel on a curved surface is proportional to its variance: w²/20 along
/// each axis for the ball, dx²/3 for B, and on average dx²/6 for linear interpolation between two cells, which is all
/// that φ has. So
///   d = φ + (w²/20 − dx²/6) / (dx²/3 − dx²/6) (d̄ − φ),   |d̄ − φ| <= 0.45 dx
/// Thin films and jets would overlap the bodies they wet by such an amount: where none of the cells is deeper than a
/// cell, d is at most boxed_distance plus the depth of the deepest, at most half a cell.
/// Beyond 2.2 dx it is boxed_distance.  Tests: tests/body/averaged_level_test.cpp
/// @param w  [m] ramp width
double averaged_distance(const MacGrid& grid, std::span<const double> phi, const Vec3& x, double w);

}  // namespace brim
