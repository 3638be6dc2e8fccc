#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "brim/body/body.h"
#include "brim/response/penalty.h"
#include "brim/solve/conjugate_gradient.h"
#include "brim/world/coarse_space.h"
#include "brim/world/contact_maps.h"
#include "brim/world/contact_preconditioner.h"
#include "brim/world/fill_stage.h"
#include "brim/world/step_report.h"

namespace brim {

/// One linearly implicit step over all bodies at once (Baraff and Witkin 1998; paper, section 6):
///   A Δv = dt (Q + dt ∂Q/∂q v) + dt Jᵀ f,   A = M − dt ∂Q/∂v − dt² ∂Q/∂q + Jᵀ (dt (dt + β) K + dt C) J
/// solved by filtered conjugate gradient; then nodes that pull let go, friction takes its new loads, and the system is
/// solved again, from what the last solve found.
/// Preconditioner: the bodies' own (block Jacobi for most), exact where contact touches (ContactFactor), and the rigid
/// motions of all bodies that deform (CoarseSpace): they cost little, and without them the residual hardly sees an
/// error of the mean motion.
class ImplicitStep {
 public:
  struct Settings {
    double dt = 0.0;
    double tolerance = 1e-4;  ///< of the last solve; those before it are drafts at ten times that
    int max_iterations = 2000;
    int passes = 3;  ///< solves at most: after each, nodes that pull let go and friction takes its new loads
    double load_tolerance = 0.01;  ///< passes end when the contact forces would change by less than this share
    /// Nonzero for bodies that are left as they are, asleep or frozen: no contact moves them; shape (bodies) or empty.
    std::span<const std::uint8_t> asleep{};
    /// How much gravity counts for each body; shape (bodies) or empty: 1.
    std::span<const double> gravity_scale{};

    /// What acts on body b. @param env  what acts on all
    Environment environment(std::size_t b, const Environment& env) const {
      return gravity_scale.empty() ? env : Environment{gravity_scale[b] * env.gravity};
    }
  };

  /// x = A⁻¹ b once the system stands.
  using Respond = std::function<SolveReport(std::span<const double> b, std::span<double> x)>;
  /// Corrects the velocity changes of the step by a means of its own (constraint rows).
  /// @param added  [N s] takes the impulses that it gave besides those of the right-hand side, shape (nv); or empty
  /// @return false when not finite
  using Correct = std::function<bool(const Respond&, std::span<double> delta, std::span<double> added)>;

  /// @param v   velocities at the start; Δv is written to `delta`
  /// @param fill  begun; has the forces of its contacts afterwards
  /// @param impulse  [N s] that acts besides, shape (nv) or empty
  /// @param correct  called after the last solve, may be empty
  /// @return false when the result is not finite
  bool solve(std::span<const std::unique_ptr<Body>> bodies, std::span<const std::size_t> first_v,
             std::span<const WorldPart> parts, const Environment& env, const ContactMaps& maps, Penalty& response,
             const ContactSet& contact_set, std::span<const double> v, const Settings& settings,
             std::span<double> delta, StepReport& report, FillStage& fill, std::span<const double> impulse = {},
             const Correct& correct = {});

  /// Relative velocity changes at the contacts, of the last solve.
  std::span<const Vec3> contact_delta() const { return contact_delta_; }
  /// What all forces but those of contact gave in the last solve, as of its start, [N s] (n_v).
  std::span<const double> inner_impulse() const { return internal_; }

 private:
  /// Bodies that contacts and links couple are solved together, others apart.
  void find_islands(std::span<const std::unique_ptr<Body>> bodies, std::span<const WorldPart> parts,
                    const ContactSet& contact_set, const Settings& settings);
  /// Tells bodies of particles which of them lie on something fixed.
  void guide(std::span<const std::unique_ptr<Body>> bodies, std::span<const std::size_t> first_v,
             const ContactMaps& maps, const Penalty& response, const ContactSet& contact_set);
  /// Where all bodies are rigid frames and nothing couples them: Δv from their own masses and inertias.
  /// @return false where some are not
  bool solve_frames(std::span<const std::unique_ptr<Body>> bodies, std::span<const std::size_t> first_v,
                    const Environment& env, const Settings& settings, std::span<const double> impulse,
                    std::span<double> delta);

  std::vector<double> internal_, rhs_, scratch_, added_;
  std::vector<Vec3> contact_delta_, contact_force_;
  std::vector<std::size_t> first_block_;
  BlockDiagonal bodies_diagonal_, diagonal_;
  ContactMaps acting_;    ///< of the contacts that act; waiting ones cost nothing in the products
  std::size_t room_ = 0;  ///< most contacts so far
  CoarseSpace modes_;
  std::vector<std::uint8_t> sparse_;            ///< per body: its maps show their rows
  std::vector<std::uint8_t> lone_;              ///< per body: one block, without coarse modes
  std::vector<std::uint8_t> without_;           ///< per body: without coarse modes
  std::vector<double> residual_;                ///< of the last solve of the passes
  std::vector<std::int32_t> island_;            ///< per body
  std::vector<double> negligible_, sharpness_;  ///< per island, as LinearSystem has them
  ContactPreconditioner preconditioner_;
  ConjugateGradient cg_;
};

}  // namespace brim
