#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "brim/mesh/tri_mesh.h"

namespace brim {

/// Signed distance [m], negative inside; called from several threads.
using DistanceFunction = std::function<double(const Vec3&)>;

enum class LatticeStyle : std::uint8_t {
  Conforming,  ///< boundary on the surface: nearby nodes are moved onto it, crossed tetrahedra are cut
  Covering     ///< all whole lattice tetrahedra that meet the inside: larger than the solid, and contains it
};

/// Tetrahedra that fill a solid, on a body-centred cubic lattice (two interleaved cubic lattices of the given spacing,
/// long edges `spacing`, short edges `spacing`·√3/2, dihedral angles 60° and 90°).
/// Conforming follows isosurface stuffing (Labelle and Shewchuk 2007): a node closer to the surface than 0.24999 of a
/// long or 0.41189 of a short edge moves onto it; tetrahedra still crossed are cut. Features thinner than about one
/// spacing may be lost.
/// @param box       [m] contains the solid
/// @param spacing   [m], > 0
/// @throws InputError  when the spacing is not positive, too fine (more than max_tets) or so coarse that nothing is
///                     left
/// Same result for any number of threads.  Tests: tests/mesh/tet_lattice_test.cpp
TetMesh tet_lattice(const DistanceFunction& distance, const Aabb& box, double spacing,
                    LatticeStyle style = LatticeStyle::Conforming, std::size_t max_tets = 20'000'000);

/// The same for a closed surface; a covering lattice also contains every vertex of the surface. If a conforming one
/// misses more than 1 % of the volume, as sharp edges between its nodes are cut off, the spacing along each axis is
/// changed so that cells end at the sides of the surface's box, where that comes nearer to the volume.
/// @throws InputError  also when the surface is not closed and oriented
TetMesh tet_lattice(const TriMesh& closed_surface, double spacing, LatticeStyle style = LatticeStyle::Conforming,
                    std::size_t max_tets = 20'000'000);

/// Shape quality of tetrahedra.
struct TetQuality {
  double min_volume = 0.0;    ///< [m³]
  double total_volume = 0.0;  ///< [m³]
  double min_dihedral = 0.0;  ///< [rad]
  double max_dihedral = 0.0;  ///< [rad]
  double min_ratio = 0.0;     ///< 6√2 V / l_rms³, 1 for the regular tetrahedron [-]
  double mean_ratio = 0.0;
};
TetQuality tet_quality(const TetMesh& mesh);

/// Fine points carried by a coarse tetrahedral mesh: x_i = Σ_k w_ik X[tets[tet_i][k]].
struct Embedding {
  std::vector<std::int32_t> tet;               ///< nearest tetrahedron, shape (n)
  std::vector<std::array<double, 4>> weights;  ///< barycentric, sum 1, negative where extrapolated, shape (n, 4)
  double farthest = 0.0;                       ///< largest distance of a point to its tetrahedron, [m]
};

/// Finds the nearest tetrahedron of each point (lowest index on ties) and the point's barycentric weights in it.
/// @throws InputError  when the mesh has no tetrahedra
Embedding embed(const TetMesh& mesh, std::span<const Vec3> points);

/// Positions of embedded points for the current vertices of the tetrahedral mesh.
std::vector<Vec3> interpolate(const Embedding& embedding, std::span<const Tetrahedron> tets,
                              std::span<const Vec3> vertices);

}  // namespace brim
