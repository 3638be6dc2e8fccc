#pragma once

#include <array>
#include <optional>
#include <vector>

#include "brim/mesh/tri_mesh.h"

namespace brim {

/// A convex solid with few flat faces: blocks, prisms, dice, stones.
struct ConvexPolyhedron {
  static constexpr int kMostFaces = 64, kMostEdges = 3 * kMostFaces - 6, kMostCorners = 2 * kMostFaces - 4;
  /// Part of the plane normal · x = offset.
  struct Face {
    Vec3 normal;    ///< unit, outwards
    double offset;  ///< [m]
  };
  /// The segment that two faces share.
  struct Edge {
    std::array<int, 2> faces, corners;
    Vec3 along;     ///< unit, from the first corner to the second
    double length;  ///< [m]
    double cosine;  ///< of the angle between the normals of the two faces
  };
  std::vector<Vec3> corners;  ///< [m]
  std::vector<Face> faces;
  std::vector<Edge> edges;
};

/// The polyhedron that a surface encloses, where its triangles form at most 64 flat faces: between two that share an
/// edge the normals turn by at most 165 degrees, at three edges of four by 15 or more; else nothing. Coordinates count
/// as exact to 1e-6 of the extent, the precision of files in single precision. Rounder surfaces stand for smooth ones,
/// and are better sampled.
/// @param mesh  closed, oriented outwards
/// Cost: O(triangles · faces).  Tests: tests/mesh/convex_polyhedron_test.cpp
std::optional<ConvexPolyhedron> convex_polyhedron(const TriMesh& mesh);

}  // namespace brim
