#pragma once

#include <span>
#include <vector>

#include "brim/math/types.h"
#include "brim/mesh/topology.h"

namespace brim {

/// What a body shows in one state, by which fluids and sheets are measured whatever their kind.
struct Shown {
  std::vector<Vec3f> x;             ///< [m]
  std::vector<Triangle> triangles;  ///< none for points and lines
  double radius = 0.0;              ///< [m] of points and lines, 0 for surfaces
};

/// Volume inside a closed surface, [m³]: sum of x_a · (x_b × x_c) / 6 over its triangles (divergence theorem).
/// Not-a-number for points and lines, which enclose none.
double enclosed_volume(const Shown& body);

/// Points of `body` that have some of `sheet` straight above them and none straight below.
int count_under(const Shown& body, const Shown& sheet);

/// Height of the upper side of a fluid, [m]: median of the highest vertex of each upright column, and its radius.
/// Columns nearer than `width` to the outline of `without` are left out. Not-a-number where none is left.
/// @param width  [m] > 0, about the distance of neighbouring vertices
double surface_level(const Shown& fluid, double width, const Shown* without = nullptr);

/// Distance of neighbouring vertices, [m]: twice the radius of points, the mean edge of a surface.
double vertex_spacing(const Shown& body);

}  // namespace brim
