#pragma once

#include <span>

#include "brim/math/types.h"
#include "brim/solve/contact_responses.h"

namespace brim {

/// Contacts with Coulomb friction by the alternating direction method of multipliers (ADMM), over-relaxed, with the
/// cones in the form of De Saxcé:
///   û = W λ + q + μ |u_t| n,   K ∋ λ  ⟂  û ∈ K*,   K: |λ_t| <= μ λ_n
/// (Carpentier, Le Lidec and Montaut, From compliant to rigid contact simulation, 2024). One iteration solves with W +
/// ρ for all contacts at once, then projects each impulse to its cone. So it depends neither on the order of the
/// contacts nor on the path of a load, and converges where projected Gauss-Seidel sweeps cycle (many contacts slipping
/// on one sheet) or crawl (contacts of unequal mass in one chain).
/// Each contact is scaled by its own response; ρ follows the ratio of the two residuals, and is refactored when
/// changed. Where the contacts outnumber the velocities that take part, the matrix of these is factored
/// (ContactResponses), else W: in single precision (DenseFactor), and if the result misses the tolerance in double,
/// further iterations use a double factor. Iterations end at three tenths of the tolerance, or when they come no
/// nearer. Same bits for any number of threads.  Tests: tests/solve/contact_admm_test.cpp
struct ContactAdmm {
  struct Report {
    int iterations = 0;
    bool converged = false;
  };

  /// @param responses  W of (u_n, u_t1, u_t2) of all contacts to their impulses, [1/kg], symmetric and positive
  ///                  semidefinite
  /// @param q         [m/s] velocities minus their targets at zero impulse, shape (n)
  /// @param friction  [-] μ, shape (n)
  /// @param tolerance [m/s] on the velocities
  /// @param impulse   [N s] λ as (n, t1, t2): initial guess on entry, within its cones on return, shape (n)
  static Report solve(ContactResponses responses, std::span<const Vec3> q, std::span<const double> friction,
                      double tolerance, int max_iterations, std::span<Vec3> impulse);
};

}  // namespace brim
