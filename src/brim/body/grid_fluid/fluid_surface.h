#pragma once

#include <functional>
#include <vector>

#include "brim/body/grid_fluid/mac_grid.h"
#include "brim/mesh/tri_mesh.h"

namespace brim {

/// Surface of a fluid for display: one vertex in every cell that the surface cuts, at the mean of its cuts with the
/// cell's edges, and a quadrilateral around every cut edge (naive surface nets: Gibson 1998).
/// @param distance  [m] signed distance at a point of the box; must not be negative on its sides
/// @param x          [m] vertices; overwritten
/// @param triangles  two per quadrilateral, counter-clockwise from outside; overwritten
void fluid_surface(const MacGrid& grid, const std::function<double(const Vec3&)>& distance, std::vector<Vec3f>& x,
                   std::vector<Triangle>& triangles);

}  // namespace brim
