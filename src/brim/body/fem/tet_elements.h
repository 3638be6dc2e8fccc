#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "brim/body/fem/tet_lanes.h"
#include "brim/body/particles/element_schedule.h"
#include "brim/math/block_matrix.h"
#include "brim/mesh/tri_mesh.h"

namespace brim {

/// Elastic forces and stiffness of linear tetrahedra.
///   F = Σ_i x_i g_iᵀ,  E = Σ_e V_e Ψ(F),  f_i = −V P g_i,  K_ij = V g_iᵀ (∂P/∂F) g_j
/// with g_i the gradients of the barycentric weights in the rest shape and V the rest volume. ∂P/∂F is projected to be
/// positive semi-definite in the principal frame, where it is sparse, and transformed back block by block. Eight
/// elements are processed at a time (TetLanes).
class TetElements {
 public:
  /// @throws InputError  when a tetrahedron has no positive volume or names a missing vertex
  TetElements(const TetMesh& rest, ElasticLaw law, const Lame& lame);

  /// Permanently scales the stiffness of elements: forces, stiffness and energy are proportional to Young's modulus.
  /// @param factor  [-] per tetrahedron of the rest mesh, positive; shape (tets)
  void scale_stiffness(std::span<const double> factor);
  /// Looks up the slots of the elements' blocks in a matrix whose pattern contains them.
  void find_pairs(const BlockMatrix& matrix);
  /// force += −∂E/∂x, stiffness += ∂²E/∂x², only the blocks above the diagonal: the caller closes the matrix. Parallel,
  /// same bits for any number of threads. About 0.15 µs per element.
  /// @return E, [J], if the law gives it as a by-product
  std::optional<double> add(std::span<const Vec3> x, std::span<Vec3> force, BlockMatrix& stiffness,
                            bool project = true) const;
  /// E, [J].
  double energy(std::span<const Vec3> x) const;

  /// Deformation gradients and first Piola-Kirchhoff stresses times the stiffness factors, in the order of the rest
  /// mesh. @param F  [-] shape (tets)  @param P  [Pa] shape (tets)
  void find_stress(std::span<const Vec3> x, std::span<Mat3> F, std::span<Mat3> P) const;

  std::size_t size() const { return volume_.size(); }
  double volume() const;
  /// A quarter of each element's mass at each of its corners, [kg], shape (vertices).
  std::vector<double> lumped_mass(std::size_t vertices, double density) const;
  /// Corners of all elements in order of evaluation, shape (4 size).
  const std::vector<std::int32_t>& nodes() const { return node_; }

 private:
  /// Index of the first lanes of a chunk; the last lanes of a chunk may repeat its last element.
  static std::size_t first_lanes(std::size_t place) { return (place + TetLanes::kCount - 1) / TetLanes::kCount; }
  /// Edges of the elements at, at + 1, ... of a chunk that ends at `end`, in lanes.
  void take_edges(std::size_t at, std::size_t end, std::span<const Vec3> x, double edge[3][3][TetLanes::kCount]) const;
  /// @param energy  per element, or empty
  void add_chunk(std::size_t begin, std::size_t end, std::span<const Vec3> x, std::span<Vec3> force,
                 BlockMatrix& stiffness, bool project, std::span<double> energy) const;

  ElasticLaw law_;
  Lame lame_;
  ElementSchedule schedule_;
  // All by place in the schedule.
  std::vector<double> volume_;
  std::vector<TetLanes> lanes_;
  std::vector<std::int32_t> node_;                 // corners, ascending
  std::vector<std::array<std::int32_t, 6>> pair_;  // 01, 02, 03, 12, 13, 23: above the diagonal
};

}  // namespace brim
