#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "brim/mesh/tri_mesh.h"

namespace brim {

using Edge = std::array<std::int32_t, 2>;

/// Classification of a triangle mesh. Plain counts, so that messages can quote them.
struct MeshReport {
  std::size_t vertices = 0, triangles = 0, edges = 0;
  std::size_t boundary_edges = 0;        ///< in only one triangle
  std::size_t nonmanifold_edges = 0;     ///< in three triangles or more
  std::size_t misoriented_edges = 0;     ///< in two triangles that traverse it in the same direction
  std::size_t nonmanifold_vertices = 0;  ///< where two fans of triangles touch in a point
  std::size_t degenerate_triangles = 0;  ///< area below 1e-12 of the squared longest edge, or a repeated corner
  std::size_t duplicate_vertices = 0;    ///< at exactly the position of an earlier vertex
  std::size_t unused_vertices = 0;       ///< in no triangle
  std::size_t repeated_triangles = 0;    ///< with the corners of an earlier one, in any order
  std::size_t pieces = 0;                ///< connected by shared vertices
  double volume = 0.0;                   ///< enclosed, [m³]; only meaningful when closed and oriented

  /// False for doubled surfaces too: their enclosed volume would count twice.
  bool closed() const { return triangles > 0 && boundary_edges == 0 && repeated_triangles == 0; }
  bool oriented() const { return misoriented_edges == 0; }
  bool manifold() const { return nonmanifold_edges == 0 && nonmanifold_vertices == 0; }
  /// One readable line, for example "5856 triangles, 2930 vertices, 1 piece, closed, manifold, oriented".
  std::string summary() const;
};

/// Inspects a mesh. O(n log n). Never throws for defective meshes.
/// @throws InputError  when a triangle names a vertex that does not exist
/// Tests: tests/mesh/topology_test.cpp
MeshReport inspect(const TriMesh& mesh);

/// Undirected edges, each once, with a < b, sorted.
std::vector<Edge> edges(std::span<const Triangle> triangles);
std::vector<Edge> edges(std::span<const Tetrahedron> tets);

/// Edges in only one triangle, in the direction in which that triangle traverses them; sorted.
std::vector<Edge> boundary_edges(std::span<const Triangle> triangles);

/// Two triangles (a, b, c) and (b, a, d) that share the edge a-b: the hinge of a bending energy.
struct Hinge {
  std::int32_t a, b;         ///< the shared edge
  std::int32_t c, d;         ///< the opposite vertices
  std::int32_t left, right;  ///< index of triangle (a, b, c) and of triangle (b, a, d)
};

/// Each interior edge once.
/// @throws InputError  when an edge has more than two triangles or two of opposite orientation
std::vector<Hinge> interior_edges(std::span<const Triangle> triangles);

/// Pieces connected by shared vertices; unused vertices have piece −1. Numbered by their lowest vertex.
struct Pieces {
  std::int32_t count = 0;
  std::vector<std::int32_t> of_vertex, of_triangle;
};
Pieces connected_pieces(std::size_t vertex_count, std::span<const Triangle> triangles);

/// Merges vertices within `tolerance` [m] of an earlier one, and removes collapsed triangles and unused vertices.
/// Tolerance 0 merges only equal positions. The order is kept.
TriMesh weld(const TriMesh& mesh, double tolerance);

/// Boundary triangles of a tetrahedral mesh, oriented outwards, indices into the tet mesh's vertices.
struct TetSurface {
  std::vector<Triangle> triangles;
  std::vector<std::int32_t> owner;  ///< tetrahedron of each triangle
};
TetSurface tet_surface(const TetMesh& mesh);

/// Outward unit normals, the mean of the adjacent face normals weighted by the corner angle; zero for unused vertices.
std::vector<Vec3> vertex_normals(std::span<const Vec3> vertices, std::span<const Triangle> triangles);

/// Splits every edge longer than max_edge [m] at its midpoint, repeatedly; the surface itself does not change, closed
/// stays closed. @throws InputError when max_edge is not positive, or the result would exceed 20 million triangles
TriMesh refine(const TriMesh& mesh, double max_edge);

/// Bounding box of points.
Aabb bounds(std::span<const Vec3> points);

}  // namespace brim
