#pragma once

#include <optional>
#include <span>
#include <vector>

#include "brim/body/fem/edge_domains.h"
#include "brim/body/fem/tet_elements.h"
#include "brim/body/meshless/sample_elements.h"

namespace brim {

/// Linear tetrahedra with a share `a` of the energy stored in edge domains, which reduces locking in bending
/// (docs/bodies/finite_elements.md):
///   E = (1 − a) Σ_e s_e V_e Ψ(F_e) + a Σ_d V_d Ψ(F̄_d)      (EdgeDomains)
/// The part in single tetrahedra resists modes that leave all means unchanged. Tests: tests/body/averaged_fem_test.cpp
class AveragedElements {
 public:
  /// @param averaging  [-] a, in [0, 1); 0: plain linear tetrahedra
  /// @param stiffness  [-] s_e of single tetrahedra, positive, shape (tets) or empty: 1
  /// @param edges      [-] of the sixths of each tetrahedron, positive, shape (tets) or empty: s_e
  /// @throws InputError  when the share is out of range, or as TetElements
  AveragedElements(const TetMesh& rest, ElasticLaw law, const Lame& lame, double averaging,
                   std::span<const double> stiffness = {}, std::span<const EdgeShares> edges = {});

  /// Builds the pattern of the stiffness.
  void make_pattern(BlockMatrix& matrix);
  /// force += −∂E/∂x, stiffness += ∂²E/∂x² above the diagonal. Parallel, same bits for any number of threads.
  /// @return E, if it is a by-product
  std::optional<double> add(std::span<const Vec3> x, std::span<Vec3> force, BlockMatrix& stiffness) const;
  double energy(std::span<const Vec3> x) const;
  const TetElements& tets() const { return tets_; }

 private:
  TetElements tets_;
  std::size_t nodes_;
  std::optional<SampleElements> domains_;  // where the share is positive
};

}  // namespace brim
