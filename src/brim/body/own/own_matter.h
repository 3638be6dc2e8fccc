#pragma once

#include <vector>

#include "brim/mesh/tri_mesh.h"

namespace brim {

/// Points that stand for the matter of a solid in sums over it.
struct MassPoints {
  std::vector<Vec3> at;      ///< [m]
  std::vector<double> mass;  ///< [kg]
};

/// Points with the mass, centre and second moments of a solid, ∫ρ, ∫ρ x, ∫ρ x xᵀ, and of its parts of about a spacing:
/// sums of functions that are quadratic in each part are exact. Each cell of a cubic lattice has four points
///   μ + C^½ s,  s = (1, 1, 1), (1, −1, −1), (−1, 1, −1), (−1, −1, 1)
/// μ, C: centre and variance of its matter, from tetrahedra (tet_lattice). What these miss of the solid is made up by
/// the symmetric map that gives all points its moments: x ← c + A (x − c'), A C' A = C.
/// @param surface  [m] closed   @param density [kg/m³]   @param spacing [m]
/// @throws InputError  as tet_lattice and mass_properties
/// Tests: tests/body/own_matter_test.cpp
MassPoints mass_points(const TriMesh& surface, double density, double spacing);

/// The surface with triangles whose edges are at most `longest`: longer ones are halved until they are.
/// @param longest  [m], > 0
TriMesh with_short_edges(const TriMesh& surface, double longest);

}  // namespace brim
