#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "brim/body/particles/element_schedule.h"
#include "brim/math/block_matrix.h"
#include "brim/mesh/tri_mesh.h"

namespace brim {

/// Resistance of a sheet to bending, one term per interior edge of length |e| between triangles of areas A₁, A₂:
///   flat rest shape     E = ½ B/(A₁+A₂) |Σ_i c_i x_i|²,  c: cotangent weights of the rest shape; quadratic, so its
///                       stiffness is constant (Bergou et al., A quadratic bending model for inextensible surfaces,
///                       2006, section 3)
///   curved rest shape   E = ½ B |e|²/(A₁+A₂) (θ − θ⁰)²,  θ: dihedral angle (Grinspun et al., Discrete shells, 2003);
///                       stiffness k ∇θ ∇θᵀ without the curvature of θ, hence positive semi-definite
/// The quadratic form is used when no rest angle exceeds 1e-6 rad. Both papers have 3/(A₁+A₂); a third of it gives a
/// rolled sheet the energy of a plate, ½ B ∫ κ² dA, on square and on equilateral meshes (for the latter it is the
/// constant of Seung and Nelson, Defects in flexible membranes with crystalline order, 1988).
class BendingElements {
 public:
  /// @param B  bending stiffness [N·m], >= 0
  /// @throws InputError  when an edge has more than two triangles or two of opposite orientation
  BendingElements(const TriMesh& rest, double B);

  bool flat() const { return flat_; }
  void find_pairs(const BlockMatrix& matrix);
  void add(std::span<const Vec3> x, std::span<Vec3> force, BlockMatrix& stiffness) const;
  double energy(std::span<const Vec3> x) const;
  std::size_t size() const { return element_.size(); }
  /// Shared edge and opposite corners of each hinge, shape (4 size).
  const std::vector<std::int32_t>& nodes() const { return node_; }

 private:
  struct Element {
    double stiffness;  // B/(A1+A2), times |e|² for angles
    double weight[4];  // c_i, flat only
    double angle;      // θ⁰
    double size2;      // (A1 + A2)², scale below which a collapsed triangle is skipped
  };
  /// Dihedral angle and its gradient; false when a triangle has collapsed.
  static bool angle(std::span<const Vec3> x, const std::int32_t* n, double size2, double& theta, Vec3 gradient[4]);

  bool flat_ = true;
  ElementSchedule schedule_;
  std::vector<Element> element_;
  std::vector<std::int32_t> node_;
  std::vector<std::array<std::int32_t, 6>> pair_;  // 01, 02, 03, 12, 13, 23
};

}  // namespace brim
