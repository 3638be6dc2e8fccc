#pragma once

#include <span>

#include "brim/body/grid_fluid/mac_grid.h"

namespace brim {

/// How far what a level set holds, cut at the box of its grid, lies from a point, [m]; trilinear, negative inside.
double boxed_distance(const MacGrid& grid, std::span<const double> phi, const Vec3& x);

/// The distance that a fluid has for contact. Solids that it meets are seen as their shares of matter in balls as wide
/// as the ramp; so its own density must be its share of such a ball, else it stands off where a solid has an edge and
/// overlaps where one bends, or the other way round. The share is known for another mean,
///   ρ̄(x) = Σ_c B(x − x_c) ramp(φ_c, 2.5 dx),   told as the distance d̄ at which a plane has this density,
/// B the cubic B-spline over 4x4x4 cells and φ_c the distance at their centres, of those beyond the box that to the box
/// at least. Which plane is the mean over its places between the cells: any one is off by 0.02 dx within a cell of it.
/// What a mean does to a bent surface goes with its variance: w²/20 along each axis for the ball, dx²/3 for B, and
/// dx²/6 on average for what is interpolated linearly between two cells, which is no more than φ. So
///   d = φ + (w²/20 − dx²/6) / (dx²/3 − dx²/6) (d̄ − φ),   |d̄ − φ| <= 0.45 dx
/// Thin films and jets would lie in what they wet by such a share: where none of the cells is deeper than a cell it is
/// no more than boxed_distance, which it may pass by as much as one is deeper, up to half a cell.
/// Beyond 2.2 dx it is boxed_distance.  Tests: tests/body/averaged_level_test.cpp
/// @param w  [m] ramp width
double averaged_distance(const MacGrid& grid, std::span<const double> phi, const Vec3& x, double w);

}  // namespace brim
