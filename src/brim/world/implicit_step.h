#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "brim/body/body.h"
#include "brim/solve/conjugate_gradient.h"
#include "brim/world/body_inverses.h"
#include "brim/world/coarse_space.h"
#include "brim/world/contact_maps.h"
#include "brim/world/contact_preconditioner.h"
#include "brim/world/step_context.h"

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

  /// @param delta  Δv, shape (nv)
  /// @param correct  called after the last solve, may be empty
  /// @return false when the result is not finite
  bool solve(const StepContext& context, const Settings& settings, std::span<double> delta,
             const Correct& correct = {});

  /// Relative velocity changes at the contacts, of the last solve.
  std::span<const Vec3> contact_delta() const { return contact_delta_; }
  /// What all forces but those of contact gave in the last solve, as of its start, [N s] (n_v).
  std::span<const double> inner_impulse() const { return internal_; }

 private:
  /// Where all bodies are rigid frames and nothing couples them: Δv from their own masses and inertias.
  /// @return false where some are not
  bool solve_frames(std::span<double> delta);
  /// Tells bodies of particles which of them lie on something fixed.
  void guide();
  /// Forces and matrices of the bodies, contact aside.
  void begin_bodies();
  /// Bodies that contacts and links couple are solved together, others apart.
  void find_islands();
  /// What the solver asks of the system: products, preconditioner, filter.
  void begin_system();
  void begin_preconditioner();
  /// Factors what yields to a fluid alone: its pressure is found through the inverse of all bodies, time and again.
  void invert_coupled(std::span<const std::uint8_t> untouched);
  void multiply(std::span<const double> x, std::span<double> y);
  void precondition(std::span<const double> r, std::span<double> z);
  /// But for what a pressure among solids does. @param left_out  of a body: true where z is left as it is
  template <class F>
  void precondition_bodies(std::span<const double> r, std::span<double> z, const F& left_out);
  template <class F>
  void filter_bodies(std::span<double> x, const F& left_out) const;
  /// Makes the preconditioner of the contacts that act.
  void prepare(bool first);
  void find_right_hand_side(bool first);
  /// Solves, and lets go of contacts and loads friction anew, until that changes little. @return false: not finite
  bool make_passes(std::span<double> delta);
  /// One of them. @param kept  no other follows  @param near  what it finds may be kept
  SolveReport solve_once(int pass, bool kept, bool near, std::span<double> delta);
  /// Hands the momentum that the solve has left over back to the bodies that it is of.
  void give_back(std::span<double> delta);
  /// Takes as negligible what rounding leaves of shifted_ once it is relieved.
  void ignore_of_relieved();
  /// Finds what a solve has left: b + added − A Δ, less what pressure resists.
  void find_residual(std::span<const double> delta, std::span<const double> added);
  bool correct_by(const Correct& correct, std::span<double> delta);
  bool asleep(std::size_t b) const { return !settings_->asleep.empty() && settings_->asleep[b] != 0; }
  /// [s] of the report that is contact's.
  double& contact_seconds() const { return context_->report.seconds[static_cast<std::size_t>(Phase::SolveContact)]; }

  // Of the solve that runs:
  const StepContext* context_ = nullptr;
  const Settings* settings_ = nullptr;
  LinearSystem system_;
  std::size_t contacts_ = 0;  ///< 0 where rows answer them all
  bool alone_ = false;        ///< rows answer all contacts of small bodies: the system is that of their own blocks
  /// Every velocity belongs to a rigid body: the factor is the whole system, but for rounding in single precision, and
  /// one iteration more makes the solution exact.
  bool whole_ = false;
  bool coarse_ = false;      ///< the coarse modes are factored
  bool settled_ = false;     ///< contact forces would change by less than the tolerance
  int iterations_made_ = 0;  ///< of the last solve for which the preconditioner was made

  std::vector<double> internal_, rhs_, scratch_, added_;
  std::vector<Vec3> contact_delta_, contact_force_;
  std::vector<std::size_t> first_block_;
  BlockDiagonal bodies_diagonal_, diagonal_;
  ContactMaps acting_;    ///< of the contacts that act; waiting ones cost nothing in the products
  std::size_t room_ = 0;  ///< most contacts so far
  CoarseSpace modes_;
  std::vector<std::uint8_t> sparse_;   ///< per body: its maps show their rows
  std::vector<std::uint8_t> lone_;     ///< per body: one block, without coarse modes
  std::vector<std::uint8_t> without_;  ///< per body: without coarse modes
  FluidCoupling::Invert invert_;       ///< precondition_bodies, filtered
  std::vector<double> filtered_, resisted_, answer_;
  std::vector<double> flowing_, shifted_;  ///< Δ₀ that makes all flow keep the volume of cells, and b − A Δ₀
  std::vector<double> residual_;           ///< of the last solve of the passes
  std::vector<double> scale_;              ///< of the first pass, for all
  std::vector<std::int32_t> island_;       ///< per body
  std::vector<double> negligible_, sharpness_;  ///< per island, as LinearSystem has them
  ContactPreconditioner preconditioner_;
  BodyInverses inverses_;               ///< of what fluids flow around and no contact acts on
  std::vector<std::uint8_t> inverted_;  ///< per body: 3 for those
  ConjugateGradient cg_;
};

}  // namespace brim
