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
/// solved by filtered conjugate gradient; then nodes that pull are released, friction takes its new loads, and the
/// system is solved again, starting from the last solution.
/// Preconditioner: the bodies' own (block Jacobi for most), exact where contact touches (ContactFactor), and the rigid
/// motions of all deformable bodies (CoarseSpace): they cost little, and without them an error of the mean motion
/// hardly shows in the residual.
class ImplicitStep {
 public:
  struct Settings {
    double dt = 0.0;
    double tolerance = 1e-4;  ///< of the last solve; earlier ones use ten times that
    int max_iterations = 2000;
    int passes =
        3;  ///< maximum number of solves; after each, pulling nodes are released and friction takes its new loads
    double load_tolerance = 0.01;  ///< passes end when the contact forces would change by less than this share
    /// Nonzero for bodies left unchanged, asleep or frozen: no contact moves them; shape (bodies) or empty.
    std::span<const std::uint8_t> unmoved{};
    /// Factor on gravity per body; shape (bodies) or empty: 1.
    std::span<const double> gravity_scale{};
  };

  /// x = A⁻¹ b, once the system is set up. @param slack  factor on the tolerance
  using Respond = std::function<SolveReport(std::span<const double> b, std::span<double> x, double slack)>;
  /// Corrects the velocity changes of the step by another method (constraint rows).
  /// @param added  [N s] set to its impulses in addition to the right-hand side, shape (nv); or empty
  /// @return false when not finite
  using Correct = std::function<bool(const Respond&, std::span<double> delta, std::span<double> added)>;

  /// @param delta  Δv, shape (nv)
  /// @param correct  called after the last solve, may be empty
  /// @return false when the result is not finite
  bool solve(const StepContext& context, const Settings& settings, std::span<double> delta,
             const Correct& correct = {});

  /// Relative velocity changes at the contacts, of the last solve.
  std::span<const Vec3> contact_delta() const { return contact_delta_; }
  /// Impulses of all forces except contact in the last solve, at its start, [N s] (n_v).
  std::span<const double> inner_impulse() const { return internal_; }

 private:
  /// Of the nodes of body b (StepContext::resistance).
  std::span<const Mat3> resistance(std::size_t b) const {
    return context_->resistance.empty() ? std::span<const Mat3>() : std::span(context_->resistance[b]);
  }
  /// Δv from masses and inertias, when all bodies are uncoupled rigid frames.
  /// @return false when some are not
  bool solve_frames(std::span<double> delta);
  /// Tells bodies of particles which of these lie on fixed parts.
  void guide();
  /// Begins the solve of all bodies.
  void begin_bodies();
  /// Forces and matrices of the bodies, without contact.
  void gather_bodies();
  /// Lets bodies add contacts of their own that the last solve closes. @return true when the system has changed
  bool foresee(std::span<const double> delta);
  /// Bodies that contacts and links couple are solved together, others apart.
  void find_islands();
  /// The solver's view of the system: products, preconditioner, filter.
  void begin_system();
  void begin_preconditioner();
  void begin_contact_preconditioner();
  /// Factors bodies that only fluids act on: the pressure is solved through the inverse of all bodies, many times.
  void invert_coupled(std::span<const std::uint8_t> untouched);
  void multiply(std::span<const double> x, std::span<double> y);
  void precondition(std::span<const double> r, std::span<double> z);
  /// Preconditioner without the pressure among solids. @param left_out  of a body: true to leave its z unchanged
  template <class F>
  void precondition_bodies(std::span<const double> r, std::span<double> z, const F& left_out);
  template <class F>
  void filter_bodies(std::span<double> x, const F& left_out) const;
  /// Builds the preconditioner of the active contacts.
  void prepare();
  void find_right_hand_side(bool first);
  /// Solves, releases contacts and updates friction loads until these change little. @return false: not finite
  bool make_passes(std::span<double> delta);
  /// One pass. @param kept  it is the last  @param near  its result may be kept
  SolveReport solve_once(int pass, bool kept, bool near, std::span<double> delta);
  /// Gives bodies the momentum missing after the solve.
  void give_back(std::span<double> delta);
  /// Sets the negligible residual from the rounding error of shifted_ after it is relieved.
  void ignore_of_relieved();
  /// Residual of a solve: b + added − A Δ, minus the part balanced by pressure.
  void find_residual(std::span<const double> delta, std::span<const double> added);
  bool correct_by(const Correct& correct, std::span<double> delta);
  bool unmoved(std::size_t b) const { return !settings_->unmoved.empty() && settings_->unmoved[b] != 0; }
  /// [s] of the report for contact in the solve.
  double& contact_seconds() const { return context_->report.seconds_of(Phase::SolveContact); }

  // Valid during a solve:
  const StepContext* context_ = nullptr;
  const Settings* settings_ = nullptr;
  LinearSystem system_;
  std::size_t contacts_ = 0;  ///< 0 when rows handle them all
  bool alone_ = false;        ///< rows handle all contacts of small bodies: the system is block-diagonal
  /// Every velocity belongs to a rigid body: the factor is the whole system up to rounding in single precision, and one
  /// more iteration makes the solution exact.
  bool whole_ = false;
  bool coarse_ = false;      ///< the coarse modes are factored
  bool plain_ = false;       ///< the contact factor is of no use: blocks alone are the preconditioner
  bool fresh_ = true;        ///< no preconditioner has been built for the present system
  bool settled_ = false;     ///< contact forces would change by less than the tolerance
  int iterations_made_ = 0;  ///< of the last solve with a newly built preconditioner

  std::vector<double> internal_, rhs_, scratch_, after_;
  std::vector<double> added_, taken_;  ///< [N s] of rows: by the last correction, and by the one before it
  std::vector<Vec3> contact_delta_, contact_force_;
  std::vector<std::size_t> first_block_;
  BlockDiagonal bodies_diagonal_, diagonal_;
  ContactMaps acting_;    ///< of the active contacts; inactive ones cost nothing in the products
  std::size_t room_ = 0;  ///< largest number of contacts so far
  CoarseSpace modes_;
  std::vector<std::uint8_t> sparse_;   ///< per body: its maps have sparse rows
  std::vector<std::uint8_t> lone_;     ///< per body: one block, without coarse modes
  std::vector<std::uint8_t> without_;  ///< per body: without coarse modes
  FluidCoupling::Invert invert_;       ///< precondition_bodies, filtered
  std::vector<double> filtered_, resisted_, answer_;
  std::vector<double> flowing_, shifted_;       ///< Δ₀ that makes all flow conserve cell volumes, and b − A Δ₀
  std::vector<double> residual_;                ///< of the last solve of the passes
  std::vector<double> scale_;                   ///< of the first pass, used by all
  std::vector<std::int32_t> island_;            ///< per body
  std::vector<double> negligible_, sharpness_;  ///< per island, as in LinearSystem
  std::vector<std::array<std::size_t, 2>> idle_;
  ContactPreconditioner preconditioner_;
  BodyInverses inverses_;               ///< of bodies in fluids without contact
  std::vector<std::uint8_t> inverted_;  ///< per body: 3 for those in inverses_
  ConjugateGradient cg_;
};

}  // namespace brim
