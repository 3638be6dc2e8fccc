#pragma once

#include <cstdint>

#include "brim/mesh/tri_mesh.h"

/// Shapes for scenes and tests. All except grid() are closed, oriented outwards and free of duplicate vertices.
/// Every function throws InputError when a size is not positive and finite or a count is too small.
/// With a `max_edge` [m], flat parts are refined until no edge is longer; 0: no refinement.
/// Tests: tests/mesh/primitives_test.cpp
namespace brim::shapes {

/// Box of the given full extent [m], centred at the origin, each side cut into subdivisions² quads of two triangles.
TriMesh box(const Vec3& extent, int subdivisions = 1);

/// Sphere [m] from an icosahedron split `level` times: 20·4^level triangles.
TriMesh icosphere(double radius, int level = 4);

/// Cylinder of the given length between two half spheres, along z, centred at the origin.
TriMesh capsule(double radius, double length, int around = 48);

/// Cylinder along z, centred at the origin.
TriMesh cylinder(double radius, double length, int around = 64, double max_edge = 0.0);

/// Ring of radius R around z, tube of radius r < R; nu steps along the ring, nv around the tube.
TriMesh torus(double R, double r, int nu = 96, int nv = 48);

/// Spur gear around z with trapezoid teeth; bore 0 means no hole.
/// @param outer, root, bore  [m] radii of the tips, of the gaps and of the hole, outer > root > bore >= 0
TriMesh gear(int teeth, double outer, double root, double thickness, double bore, double max_edge = 0.0);

/// Star with flat faces, extruded along z. outer > inner > 0.
TriMesh star(int points, double outer, double inner, double thickness, double max_edge = 0.0);

/// Sphere with smooth random lumps and dents, star-shaped about the origin, not convex. The same seed gives the same
/// shape.
/// @param radius  [m] of the sphere before the lumps
TriMesh blob(std::uint64_t seed, double radius = 1.0, int level = 4);

/// Half-sphere shell, open towards +z, with a rounded rim; the outer sphere's centre is the origin.
TriMesh bowl(double radius, double thickness, int around = 64);

/// Cylindrical beaker with a floor, open towards +z, standing on z = 0.
TriMesh cup(double radius, double height, double thickness, int around = 64, double max_edge = 0.0);

/// L-shaped bar: legs along +x and +y of the given lengths and width, extruded along z, corner at the origin.
TriMesh l_profile(double leg_x, double leg_y, double width, double length, double max_edge = 0.0);

/// U-shaped bar: floor along x of full width `outer`, walls up +y of `height`, extruded along z, centred in x and z.
TriMesh u_profile(double outer, double height, double thickness, double length, double max_edge = 0.0);

/// Open rectangular sheet in the plane z = 0, centred, normal +z, nx by ny cells with alternating diagonals.
TriMesh grid(int nx, int ny, double lx, double ly);

}  // namespace brim::shapes
