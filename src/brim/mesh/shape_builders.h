#pragma once

#include <vector>

#include "brim/mesh/tri_mesh.h"

/// Construction of the primitives: profiles revolved around z or extruded along z.
namespace brim::shapes {

/// A point of the half plane revolved around z, [m].
struct RZ {
  double r, z;
};

/// A point of a flat outline, [m].
struct XY {
  double x, y;
};

/// Revolves a profile around z. The profile goes from axis to axis (r = 0 at both ends, r > 0 between) with the outside
/// on its right.
TriMesh revolve(const std::vector<RZ>& profile, int around);

/// Extrudes a counter-clockwise outline that is star-shaped about the origin along z, centred, with a round hole of
/// radius `bore` (0: none) whose corners lie on the same rays as the outline's.
TriMesh extrude_around_center(const std::vector<XY>& outline, double bore, double thickness);

/// Extrudes a simple counter-clockwise outline along z, centred; caps by ear clipping.
TriMesh extrude_polygon(const std::vector<XY>& outline, double length);

}  // namespace brim::shapes
