#pragma once

#include "brim/mesh/tri_mesh.h"

namespace brim {

/// Mass, centre and inertia of a solid of constant density.
struct MassProperties {
  double volume = 0.0;          ///< [m³]
  double mass = 0.0;            ///< [kg]
  Vec3 center = Vec3::Zero();   ///< centre of mass, [m]
  Mat3 inertia = Mat3::Zero();  ///< about the centre of mass, axes of the mesh, [kg m²]
};

/// Exact integrals over the solid inside a closed surface, as a sum of tetrahedra from one reference point:
///   V = Σ det/6,  ∫x = Σ det/24 (a+b+c),  ∫x xᵀ = Σ det/120 (a aᵀ + b bᵀ + c cᵀ + s sᵀ),  s = a+b+c
/// with det = a·(b×c), a, b, c the corners relative to the reference point (the centre of the mesh's bounding box,
/// which keeps cancellation small). Then I = ρ (tr(C) 1 − C), C = ∫(x−c)(x−c)ᵀ.
/// The same integrals as Mirtich, "Fast and accurate computation of polyhedral mass properties" (1996), by another
/// method.
/// @param mesh     closed and oriented outwards; results are meaningless for an open one, see inspect()
/// @param density  [kg/m³], > 0
/// @throws InputError  when density is not positive and finite, or the volume is not positive (open or inside out)
/// Tests: tests/mesh/mass_properties_test.cpp
MassProperties mass_properties(const TriMesh& mesh, double density);

/// The same for a tetrahedral mesh.
MassProperties mass_properties(const TetMesh& mesh, double density);

/// Volume enclosed by a closed surface, [m³]; negative when it is inside out.
double enclosed_volume(const TriMesh& mesh);

/// Sum of the triangle areas, [m²].
double surface_area(const TriMesh& mesh);

/// Volume of one tetrahedron, [m³]: det(b−a, c−a, d−a) / 6.
inline double tet_volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return (b - a).cross(c - a).dot(d - a) / 6.0;
}
/// Of each tetrahedron, [m³].
std::vector<double> tet_volumes(const TetMesh& mesh);

}  // namespace brim
