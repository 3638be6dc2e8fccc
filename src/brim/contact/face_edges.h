#pragma once

#include <span>

#include "brim/contact/cube_contacts.h"

namespace brim {

/// Carries contact points at the rim of a face shared by two solids to the edge of the face. A node stands for a cell
/// of the face; its outermost nodes lie up to a voxel inside the edge, and a body supported there would topple as if
/// its base were that much smaller. The distances d_a, d_b to the solids give the edge:
///   x ← x + t e,   t < reach: distance along the face at which the line of d_a + d_b beyond the edge meets its level
/// e: perpendicular to n and towards the nearest edge, along the gradient of d_a + d_b beyond it, and then across it,
/// for corners. Sampled distances begin to rise up to half a voxel before an edge, so searches start further inside.
/// Where d_a + d_b also changes the opposite way, or rises slowly, the surface is curved and x stays.
/// Points are evaluated in batches, and only points near an edge at more than five places.
/// @param points   [m] moved  @param reach  [m]
/// @param normals  unit, perpendicular to the face  @param h  [m] step of the grid
/// Tests: tests/contact/face_edges_test.cpp
void carry_to_edges(const CubeSide& a, const CubeSide& b, double h, double reach, std::span<Vec3> points,
                    std::span<const Vec3> normals);

/// The same for the points of all contacts between two solids, with a reach of h.
void carry_to_edges(const CubeSide& a, const CubeSide& b, double h, std::span<Contact> contacts);

}  // namespace brim
