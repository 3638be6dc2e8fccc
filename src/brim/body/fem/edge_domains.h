#pragma once

#include <array>
#include <span>
#include <vector>

#include "brim/body/meshless/moving_least_squares.h"
#include "brim/mesh/tri_mesh.h"

namespace brim {

/// Stiffness of the sixths of a tetrahedron nearest to its edges 01, 02, 03, 12, 13 and 23, relative to that of the
/// material, [-]. A point is nearest to an edge when the weights of the edge's ends are the largest of the four.
using EdgeShares = std::array<double, 6>;

/// Edge domains, whose mean deformation gradient stores energy (edge-based smoothed strain: Liu, Nguyen-Thoi and Lam
/// 2009, in space Cazes and Meschke 2013). A domain consists of the sixth of every adjacent tetrahedron about the edge,
///   V = Σ_e s_e V_e / 6,   F̄ = Σ_e s_e V_e F_e / 6V = Σ_k x_k ḡ_kᵀ,   ḡ_k = Σ_e s_e V_e g_e,k / 6V
/// with V_e the volume, s_e the stiffness of its sixth and g_e,k the gradient of corner k's barycentric weight in
/// tetrahedron e.
struct EdgeDomains {
  ShapeFunctions shape;        ///< only nodes, ascending in each row, and gradients; the weights are zero
  std::vector<double> volume;  ///< [m³] V, shape (edges)
};
/// @param mesh       rest shape, every tetrahedron with positive volume
/// @param stiffness  [-] positive, shape (tets)
/// Tests: tests/body/averaged_fem_test.cpp
EdgeDomains edge_domains(const TetMesh& mesh, std::span<const EdgeShares> stiffness);

/// Domains of the edges 01, 02, 03, 12, 13 and 23 of every tetrahedron, shape (tets).
std::vector<std::array<std::int32_t, 6>> domains_of_tets(const TetMesh& mesh);

}  // namespace brim
