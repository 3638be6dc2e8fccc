#pragma once

#include <span>

#include "brim/mesh/tet_lattice.h"

namespace brim {

/// The tetrahedra of a body-centred cubic lattice that hold the given points, and where each point is in them. For
/// solids that are given by points of matter: every point is held, features thinner than the spacing included.
/// @param spacing  [m] long edge
/// @param edges    [m] of the cube of matter about each point, whose tetrahedra are taken too so that none is missing
///                 between points; 0: the point alone. One per point or empty
/// @throws InputError  when there are no points, or the lattice would pass max_tets
/// Tests: tests/mesh/lattice_around_test.cpp
struct HeldPoints {
  TetMesh mesh;
  Embedding embedding;
};
HeldPoints lattice_around(std::span<const Vec3> points, double spacing, std::span<const double> edges = {},
                          std::size_t max_tets = 20'000'000);

}  // namespace brim
