#pragma once

#include "brim/math/types.h"

namespace brim {

/// Isotropic elastic law for a deformation F = U diag(s) Vᵀ (energy density per rest volume, [J/m³ = Pa]).
enum class ElasticLaw {
  /// µ |F − R|² + λ/2 (Σs − 3)²: linear stress in stretch, exact rotations; forgiving, recovers from inversion.
  /// (Sifakis and Barbic, FEM simulation of 3D deformable solids, 2012.)
  CorotationalLinear,
  /// µ'/2 (|F|² − 3) + λ'/2 (det F − α)² − µ'/2 log(|F|² + 1) + const: preserves volume, stiffens, survives inversion.
  /// µ' = 4µ/3, λ' = λ + 5µ/6, α = 1 + 3µ'/(4λ') (Smith, de Goes and Kim, Stable neo-Hookean flesh simulation, 2018,
  /// eq. 14, and section 3.4 for the constants).
  StableNeoHookean
};

/// Lamé constants of Hooke's law for small strain, [Pa].
struct Lame {
  double mu, lambda;
  /// @param young  E [Pa], > 0; @param poisson  ν [-], in (−1, 0.5)
  static Lame from(double young, double poisson) {
    return {young / (2.0 * (1.0 + poisson)), young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson))};
  }
};

/// Constants of the stable neo-Hookean energy that agree with Hooke's law at rest.
struct StableNeoHookean {
  double mu, lambda, alpha;  ///< µ' [Pa], λ' [Pa], α [-]
  explicit StableNeoHookean(const Lame& l) : mu(4.0 * l.mu / 3.0), lambda(l.lambda + 5.0 * l.mu / 6.0) {
    alpha = 1.0 + 0.75 * mu / lambda;
  }
};

/// Derivatives of an isotropic energy density in the frame of its principal stretches s. With P = ∂Ψ/∂F,
///   Uᵀ P V = diag(first),
///   ∂P/∂F in that frame: `stretch` couples the diagonal; the pair (i, j) has two more eigenvectors, antisymmetric
///   with value `twist` = (ψ_i + ψ_j)/(s_i + s_j) and symmetric with value `flip` = (ψ_i − ψ_j)/(s_i − s_j).
/// Pair k is (i, j) with i, j ≠ k.
/// (Smith, de Goes and Kim, Analytic eigensystems for isotropic distortion energies, 2019.)
struct PrincipalResponse {
  double energy = 0.0;
  Vec3 first = Vec3::Zero();
  Mat3 stretch = Mat3::Zero();
  Vec3 twist = Vec3::Zero(), flip = Vec3::Zero();
};

/// @param s        principal stretches, the last may be negative
/// @param project  clamp the eigenvalues of ∂P/∂F at zero, so that the stiffness is positive semi-definite
/// Tests: tests/body/elastic_law_test.cpp
PrincipalResponse principal_response(ElasticLaw law, const Lame& lame, const Vec3& s, bool project = true);

/// First Piola-Kirchhoff stress P = ∂Ψ/∂F, [Pa].
Mat3 first_piola_stress(ElasticLaw law, const Lame& lame, const Mat3& F);

/// Only the energy density.
double elastic_energy_density(ElasticLaw law, const Lame& lame, const Vec3& s);

/// Nearest positive semi-definite matrix to a symmetric one.
Mat3 clamp_to_positive(const Mat3& symmetric);

}  // namespace brim
