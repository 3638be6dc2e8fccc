#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "brim/body/particles/element_schedule.h"
#include "brim/math/block_matrix.h"

namespace brim {

/// Bending stiffness of a line, one term per node with a neighbour on both sides. t_0, t_1: directions of the two
/// edges, of rest lengths L_0 and L_1; φ: angle between them:
///   κ = 2 t_0×t_1 / (1 + t_0·t_1)    curvature binormal, |κ| = 2 tan(φ/2)
///   E = Σ ½ k (|κ| − κ⁰)²            k = 2 B / (L_0 + L_1)
/// (Bergou et al., Discrete elastic rods, 2008, section 4.2, for an isotropic rod without twist.) A rod with a curved
/// rest shape keeps the magnitude of its curvature, not its plane: that would take a material frame. The energy grows
/// without bound as an edge folds onto the other.
/// With J = ∂κ/∂x and u = κ/|κ| the force is −k (1 − κ⁰/|κ|) Jᵀκ and the stiffness that of a spring in the space of κ,
///   K = k Jᵀ [ u uᵀ + max(0, 1 − κ⁰/|κ|) (I − u uᵀ) ] J
/// without the derivative of J: exact for a straight rod, always positive semi-definite.
class RodBending {
 public:
  RodBending() = default;
  /// @param triples  (before, node, after) of each bent node  @param x  rest positions, [m]
  /// @param B        flexural rigidity E I [N m²], >= 0
  /// @param bent     true: κ⁰ is that of the rest positions; false: the rod rests straight
  /// @throws InputError  when a rest shape folds back onto itself
  RodBending(std::span<const std::array<std::int32_t, 3>> triples, std::span<const Vec3> x, double B, bool bent);

  void find_pairs(const BlockMatrix& matrix);
  /// force += −∂E/∂x; stiffness and damper += K. Parallel, same bits for any number of threads.
  void add(std::span<const Vec3> x, std::span<Vec3> force, BlockMatrix& stiffness, BlockMatrix& damper) const;
  /// E, [J].
  double energy(std::span<const Vec3> x) const;
  std::size_t size() const { return element_.size(); }
  /// Nodes of all terms in order of evaluation, shape (3 size).
  const std::vector<std::int32_t>& nodes() const { return node_; }

 private:
  struct Element {
    double stiffness;  // k [N m]
    double curvature;  // κ⁰ [-]
  };
  ElementSchedule schedule_;
  std::vector<Element> element_;
  std::vector<std::int32_t> node_;
  std::vector<std::array<std::int32_t, 3>> pair_;  // 01, 02, 12
};

}  // namespace brim
