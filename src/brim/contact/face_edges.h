#pragma once

#include <span>

#include "brim/contact/cube_contacts.h"

namespace brim {

/// A node stands for a cell of the face that two solids share; where the face ends within a voxel of it, the cell ends
/// there too. The outermost nodes lie up to a voxel inside of the edge, and a body that stands on them alone would
/// topple as if its base were that much smaller. So their points are carried to the edge, which the distances know:
///   x ← x + t e,   t < reach the way along the face at which d_a + d_b begins to rise as fast as beyond an edge
/// along two directions across n, one after the other. Sampled distances begin to rise up to half a voxel before the
/// edge, and less than beyond it: there t is where the line through d_a + d_b farther out meets the face's. Where
/// d_a + d_b changes the other way too, there is no face but a curved surface, and x stays. Points are asked for
/// together, and only those near an edge for more than five places.
/// @param points   [m] moved  @param reach  [m]
/// @param normals  unit, across the face  @param h  [m] step of the grid
/// Tests: tests/contact/face_edges_test.cpp
void carry_to_edges(const CubeSide& a, const CubeSide& b, double h, double reach, std::span<Vec3> points,
                    std::span<const Vec3> normals);

/// The same for all points of contacts between two solids, with a reach of h.
void carry_to_edges(const CubeSide& a, const CubeSide& b, double h, std::span<Contact> contacts);

/// Where a face ends, from its outermost node in some direction: the same within two voxels, and within four where the
/// way leads out from the middle of the face.
/// @param x  [m]  @param n  unit, across the face  @param middle  [m]
Vec3 carried_to_corner(const CubeSide& a, const CubeSide& b, double h, const Vec3& x, const Vec3& n,
                       const Vec3& middle);

}  // namespace brim
