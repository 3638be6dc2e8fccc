#pragma once

#include <span>
#include <vector>

#include "brim/body/grid_fluid/mac_grid.h"
#include "brim/mesh/tri_mesh.h"

namespace brim {

/// Surface of a fluid for display: one vertex in every cube between eight neighbouring cell centres that the surface
/// cuts, at the mean of its cuts with the cube's edges, and a quadrilateral around every cut edge (naive surface nets:
/// Gibson 1998). Cubes that reach beyond the box have their vertices on its sides, so that a pool fills its box to the
/// edges and corners; they leave a side where the surface, continued straight, cuts the half cell before it.
/// A layer whose surface lies below the first cell centres is not seen.
/// @param distance   [m] signed distance, one per cell, negative in the fluid
/// @param x          [m] vertices; overwritten
/// @param triangles  two per quadrilateral, counter-clockwise from outside; overwritten. The surface is closed.
/// Tests: tests/body/fluid_surface_test.cpp
void fluid_surface(const MacGrid& grid, std::span<const double> distance, std::vector<Vec3f>& x,
                   std::vector<Triangle>& triangles);

}  // namespace brim
