#pragma once

#include <vector>

#include "brim/body/meshless/moving_least_squares.h"
#include "brim/mesh/tri_mesh.h"

namespace brim {

/// Tetrahedra that share their longest edge, as domains whose mean deformation gradient stores energy:
///   F̄ = Σ_e V_e F_e / V = Σ_k x_k ḡ_kᵀ,   ḡ_k = Σ_e V_e g_e,k / V,   V = Σ_e V_e
/// with g_e,k the gradient of corner k's barycentric weight in tetrahedron e (smoothed strain: Liu, Dai and Nguyen
/// 2007). Of edges as long to 1e-6, that one counts whose lower node is higher. On a body-centred lattice the four
/// tetrahedra about an edge between two centres make a group, an octahedron.
struct EdgeGroups {
  ShapeFunctions shape;        ///< only nodes, ascending in each row, and gradients; the weights are zero
  std::vector<double> volume;  ///< [m³] V, shape (groups)
};
/// @param mesh  rest shape, every tetrahedron with positive volume
/// Tests: tests/body/averaged_fem_test.cpp
EdgeGroups edge_groups(const TetMesh& mesh);

}  // namespace brim
