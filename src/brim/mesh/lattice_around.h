#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "brim/mesh/tet_lattice.h"

namespace brim {

/// The tetrahedra of a body-centred cubic lattice that hold the given points, and where each point is in them. For
/// solids that are given by points of matter: every point is held, features thinner than the spacing included.
/// @param spacing  [m] long edge
/// @param cube     [m] edge of the cube of matter about each point
/// @param whole    nonzero for points whose cubes are held too, so that no tetrahedron is missing between points; the
///                 others are held alone. One per point or empty: none
/// @throws InputError  when there are no points, or the lattice would pass max_tets
/// Tests: tests/mesh/lattice_around_test.cpp
struct HeldPoints {
  TetMesh mesh;
  Embedding embedding;
  std::vector<double> outside;  ///< [-] share of each point's cube that lies in none of the tetrahedra; about
};
HeldPoints lattice_around(std::span<const Vec3> points, double spacing, double cube = 0.0,
                          std::span<const std::uint8_t> whole = {}, std::size_t max_tets = 20'000'000);

}  // namespace brim
