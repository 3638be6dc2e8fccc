#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "brim/mesh/tet_lattice.h"

namespace brim {

/// The tetrahedra of a body-centred cubic lattice that contain the given points, and the points' barycentric positions.
/// For solids given by points of matter: every point is contained, also in features thinner than the spacing.
/// @param spacing  [m] long edge
/// @param cube     [m] edge of the cube of matter about each point
/// @param whole    nonzero for points whose whole cubes must be contained, so that no tetrahedron is missing between
///                 points; for the others the point suffices. One per point or empty: none
/// @throws InputError  when there are no points, or the lattice would exceed max_tets
/// Tests: tests/mesh/lattice_around_test.cpp
struct HeldPoints {
  TetMesh mesh;
  Embedding embedding;
  std::vector<double> outside;  ///< [-] fraction of each point's cube outside the tetrahedra; about
};
HeldPoints lattice_around(std::span<const Vec3> points, double spacing, double cube = 0.0,
                          std::span<const std::uint8_t> whole = {}, std::size_t max_tets = 20'000'000);

}  // namespace brim
