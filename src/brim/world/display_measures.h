#pragma once

#include <span>
#include <vector>

#include "brim/math/types.h"
#include "brim/mesh/topology.h"

namespace brim {

/// Display geometry of a body in one state, from which fluids and sheets of any kind are measured.
struct Shown {
  std::vector<Vec3f> x;             ///< [m]
  std::vector<Triangle> triangles;  ///< empty for points and lines
  double radius = 0.0;              ///< [m] of points and lines, 0 for surfaces
};

/// Volume inside a closed surface, [m³]: sum of x_a · (x_b × x_c) / 6 over its triangles (divergence theorem).
/// NaN for points and lines, which enclose none.
double enclosed_volume(const Shown& body);

/// Number of points of `body` with `sheet` straight above them and not straight below.
int count_under(const Shown& body, const Shown& sheet);

/// Height of a fluid's upper surface, [m]: median over vertical columns of the highest vertex plus its radius. Columns
/// closer than `width` to the outline of `without` are left out. NaN when none is left.
/// @param width  [m] > 0, about the distance of neighbouring vertices
double surface_level(const Shown& fluid, double width, const Shown* without = nullptr);

/// Distance of neighbouring vertices, [m]: twice the radius of points, the mean edge length of a surface.
double vertex_spacing(const Shown& body);

}  // namespace brim
