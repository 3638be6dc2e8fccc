#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "brim/body/body.h"
#include "brim/body/rigid_frame.h"
#include "brim/response/constraint.h"
#include "brim/solve/projected_gauss_seidel.h"
#include "brim/world/body_inverses.h"
#include "brim/world/contact_maps.h"
#include "brim/world/direct_rows.h"
#include "brim/world/implicit_step.h"
#include "brim/world/islands.h"
#include "brim/world/row_memory.h"
#include "brim/world/step_report.h"
#include "brim/world/turning.h"

namespace brim {

/// Contacts held by constraint rows, on top of the implicit step (paper, sections 4.3 and 6):
///   u = J (v + Δv) + ...,  Δv = A⁻¹ (b + Jᵀ λ),  λ in Coulomb's cone, u_n >= target
/// with A the implicit matrix of all bodies and of the penalty contacts. Projected Gauss-Seidel runs on J P Jᵀ, P: the
/// bodies' own inverses (BodyInverses). Where P = A⁻¹ (bodies of few velocities without penalty contacts, and larger
/// ones whose A can be factored) its result is the solution. Elsewhere it gives a direction d in λ; A⁻¹ Jᵀ d comes from
/// the step's own solve, λ moves along d as far as the two agree, and so on until d no longer changes any velocity.
/// Points that rows connect only with bodies of the first sort are left to the sweeps in either case.
/// Pairs of rigid bodies (RigidFrame) need only lever arms and inverse inertias, no maps (RigidPairRows).
class ConstraintStep {
 public:
  struct Settings {
    ConstraintOptions rows;
    double tolerance = 1e-4;  ///< relative change of velocity at which sweeps end
    int max_sweeps = 200;
    double scale = 0.0;  ///< [m/s] reference velocity: that of a free fall over the step
  };

  /// To be called when bodies have been replaced by other objects.
  void forget_bodies() { rigid_.clear(); }
  /// Gathers rows from the contacts, and impulses from the last step.
  /// @param gathered  rows of rigid pairs that are not among the contacts
  /// @param memory    rows of the last step (World::State)
  void begin(std::span<const std::unique_ptr<Body>> bodies, std::span<const std::size_t> first_v,
             std::span<const WorldPart> parts, const ContactSet& contacts, std::span<const Vec3> normals,
             std::span<const ConstraintPair> pairs, const GatheredRows& gathered, std::span<const double> v,
             const Settings& settings, std::span<const double> memory);
  bool empty() const { return rows_.points().size() == 0; }
  /// The points of the rows, and their initial normal impulses [N s]: those of the last step.
  const ContactSet& points() const { return rows_.points(); }
  double first_impulse(std::size_t c) const { return lambda_[c].x(); }
  /// Jᵀ λ of the initial guess, [N s], shape (nv).
  std::span<const double> impulse() const { return impulse_; }

  /// Corrects the velocity changes of the implicit step, which contain the initial guess already. May be called again
  /// in a step, for changes found anew that contain what it has added.
  /// @param solve  x = A⁻¹ b  @param delta  Δv, shape (nv)
  /// @param added  [N s] set to Jᵀ (λ − initial guess), shape (nv); or empty
  /// @return false when a value is not finite
  bool correct(const ImplicitStep::Respond& solve, std::span<double> delta, std::span<double> added,
               StepReport& report);
  /// False when the last correct() ended with a residual that gave a warning.
  bool converged() const { return converged_; }
  /// Mean velocity of the step minus that at its end, for the positions; shape (nv), or empty when they are equal.
  std::span<const double> position_correction() const { return position_correction_; }

  /// Adds forces to the reports of pairs and to the samples, checks momentum, and stores λ for the next step.
  void finish(StepReport& report, std::vector<ContactSample>& samples, bool check, std::vector<double>& memory) const;

 private:
  /// Finds which bodies have rows, of which form, and which have penalty contacts too.
  void mark_bodies(const ContactSet& contacts, std::span<const ConstraintPair> pairs, const GatheredRows& gathered);
  /// True when lever arms describe the pair: the bodies of both parts are rigid frames.
  bool rigid(std::int32_t a, std::int32_t b) const { return frame_of(a) != nullptr && frame_of(b) != nullptr; }
  bool rigid(const ContactPair& pair) const { return rigid(pair.part_a, pair.part_b); }
  const RigidFrame* frame_of(std::int32_t part) const { return rigid_[parts_[part].body_index]; }
  /// Calls f(pair, contact, arm on a, arm on b) for all points, where all pairs are rigid.
  template <class F>
  void for_arms(const F& f) const;
  void build_maps();
  void find_start(std::span<const double> v);
  /// Places the rows of balls that will hit each other where they touch (find_round_impact), with the bodies where they
  /// are then.
  void find_round_impacts(std::span<const double> v);
  /// Lets rows of solids that touch at one point of curved surfaces act where and as these lie in the middle of the
  /// step: v' = v + α n with n of the middle turns a velocity without changing its size, as α n of the start, where n·v
  /// = 0 already, does not turn it, and that of the end shortens it by half the square of the angle.
  void follow_curves(std::span<const double> v);
  /// Sets displacements back to the chord of the way along a curved surface, from its direction at the end of the step:
  /// those of bodies without other contacts to the mean of their velocities at the start and the end, gravity included.
  /// @return per body: it goes by that mean
  std::vector<std::uint8_t> go_along_curves(std::vector<Vec3>& lambda, std::vector<double>& way) const;
  /// Velocity of a rigid part's or a link's material at x, [m/s].
  Vec3 velocity_of(std::int32_t part, const Vec3& x, std::span<const double> v) const;
  /// Velocity of a rigid part, [m/s]. @param arm  [m] from its centre
  Vec3 velocity_at(std::int32_t part, const Vec3& arm, std::span<const double> v) const;
  /// Calls f(pair, contact, offset of the friction point) for points whose friction acts elsewhere, when all pairs are
  /// rigid.
  template <class F>
  void for_grips(const F& f) const;
  /// Q += Jᵀ f for the forces on a at all points.
  void add_forces(std::span<const Vec3> force, std::span<double> Q) const;
  void add_mapped_forces(std::span<const Vec3> force, std::span<double> Q) const;
  void recall(std::span<const double> memory);
  /// Spreads the loads that points of flat contacts of rigid bodies share anew evenly (even_loads).
  void even_out();
  /// @param way  [m] that the body has gone when the rows act
  RigidPairRows::Side side_of(std::int32_t part, const Vec3& way) const;
  void assemble();
  /// Chooses the bodies' inverses: all exact when affordable and no penalty contact is involved.
  void choose_inverses();
  /// True when the sweeps know how the body responds: its inverse is exact and no penalty contact holds it.
  bool knows(std::size_t body) const {
    return !(touched_[body] && !inverses_.exact(body)) && !(held_[body] && mixed_[body]);
  }
  /// Marks the points that rows connect only with bodies that the sweeps know, and numbers the islands of the others.
  void find_known();
  /// Calls f(body, side a, side b) for the bodies that have rows at the pair's contacts.
  template <class F>
  void for_bodies(const ContactPair& pair, const F& f) const;
  /// Forces of the body for unit impulses along the rows of contact c of pair p, filtered, into force_.
  void find_forces(std::size_t p, std::size_t c, std::size_t body, bool side_a, bool side_b);
  void add_row(std::size_t p, std::size_t c);
  /// The same of a rigid pair, in the general form.
  void add_rigid_row(std::size_t p, std::size_t c);
  /// Lets impacts follow each other within the step: a bouncing body passes its speed on to those it touches.
  /// @param v  velocity changes of the motion without contacts
  void pass_impacts_on(std::vector<double> v);
  /// Solves for the targets, starting from λ and Δv. @param most  maximum number of solves with A
  void solve_rows(const ImplicitStep::Respond& solve, std::span<const double> target, int most,
                  std::vector<Vec3>& lambda, std::vector<double>& delta, double& residual, StepReport& report);
  /// Moves the friction of sliding faces to the centre of their load (Constraint::center_friction), once this is known,
  /// for bodies that touch fixed parts alone.
  /// @param lambda, change  solution; the change of velocity follows  @param added  [N s] empty, or follows
  /// @return false when nothing moves
  bool center_friction(std::span<const Vec3> lambda, std::span<double> change, std::span<double> added);
  /// Residual that gives a warning; sweeps that end above it are continued.
  double warn_above() const;
  /// Bodies that rows connect.
  Islands join_rows() const;
  std::int32_t moving_body(const ContactPair& p) const {
    return parts_[is_fixed(parts_[p.part_a]) ? p.part_b : p.part_a].body_index;
  }
  /// Number of points in the largest group of bodies connected by rows.
  std::size_t most_together() const;
  int find_most_sweeps() const;
  /// Adds to the displacements of the step, and to their impulses, a frictionless correction of overlaps along the
  /// normals.
  void push_apart(std::vector<Vec3>& lambda, std::vector<double>& way, StepReport& report);
  /// Lets what is hit at a time τ of the step move on from there by what its impulses changed: they count 1 − τ/dt of
  /// themselves in its displacement, friction included, so that no angular momentum is lost.
  /// @return false, and nothing changed, where a body that is hit has other rows too: their impulses depend on it
  bool follow_bends(std::vector<Vec3>& lambda, std::vector<double>& way) const;
  /// Number of rows of each body.
  std::vector<std::size_t> rows_of_bodies() const;
  /// Calls f(body) for the bodies of a pair that can move.
  template <class F>
  void for_movable(const ContactPair& pair, const F& f) const {
    for (const std::int32_t part : {pair.part_a, pair.part_b})
      if (!is_fixed(parts_[part])) f(static_cast<std::size_t>(parts_[part].body_index));
  }
  /// How far the refinement of an island has come.
  struct Refined {
    double scale = 0.0;   ///< [m/s] velocity by which its misses are judged
    double missed = 0.0;  ///< change that the last direction still asked for, relative to scale
    bool done = false;
  };
  void refine(const ImplicitStep::Respond& solve, std::span<const double> target, int most, std::vector<Vec3>& lambda,
              std::vector<double>& delta, double& residual, StepReport& report);
  /// Solves islands whose directions do not settle, all their points at once (ContactAdmm), with the responses that the
  /// step's own solve gives to each of their rows.
  /// @param islands  those that are not done; what is solved is marked  @param most  points of one
  void solve_columns(const ImplicitStep::Respond& solve, std::span<const double> target, std::size_t most,
                     std::span<Refined> islands, std::vector<Vec3>& lambda, std::vector<double>& delta,
                     StepReport& report);
  double longest_way(std::int32_t island, std::span<const Vec3> from, std::span<const Vec3> way, double most) const;

  std::span<const std::unique_ptr<Body>> bodies_;
  std::span<const std::size_t> first_v_;
  std::span<const WorldPart> parts_;
  Settings settings_;
  Constraint rows_;
  std::vector<std::uint8_t> apart_;  ///< per point: friction acts at another place than the normal force
  ContactMaps maps_, grip_maps_;
  ContactSet gripped_;                ///< friction points of the mapped points whose friction acts elsewhere
  std::vector<std::size_t> grip_of_;  ///< per entry of gripped_, the point
  BodyInverses inverses_;
  DirectRows direct_;
  std::size_t width_ = 0;  ///< number of unknowns of the sweeps: velocities, rigid motions, coordinates of direct rows
  ProjectedGaussSeidel sweep_;
  std::vector<std::uint8_t> held_;        ///< per body: has rows
  std::vector<std::uint8_t> touched_;     ///< per body: has rows of the general form
  std::vector<std::uint8_t> mixed_;       ///< per body: has penalty contacts
  std::vector<const RigidFrame*> rigid_;  ///< per body, or null
  RowMemory recall_;
  Turning turning_;
  bool mapped_ = false;  ///< some pair is not rigid: points have maps
  bool solids_ = true;   ///< all rows are between rigid frames, or solids of articulated bodies
  bool exact_ = true, converged_ = true;
  std::vector<std::uint8_t> known_;                    ///< per point, unless exact_: the sweeps solve it (find_known)
  Islands coupled_{0};                                 ///< bodies that contacts, links or rows of any sort connect
  std::vector<std::int32_t> island_of_body_, island_;  ///< numbers of these islands, per body and per point
  std::size_t islands_ = 0;
  int most_sweeps_ = 0;

  std::vector<Mat3> frame_;  ///< rows n, t1, t2
  /// [m/s] per point: normal velocity at the end of the step of what follows a curved surface.
  std::vector<double> lift_;
  /// Per pair: it touches at one point of a curved surface, above which it may be yet, or along which it moves already.
  enum Follows : std::uint8_t { kNot, kAbove, kAlong };
  std::vector<std::uint8_t> follows_;
  /// [m] ways of the two bodies of a pair to the moment that its row describes: of an impact, or the middle of the
  /// step.
  struct Ways {
    Vec3 a = Vec3::Zero(), b = Vec3::Zero();
  };
  std::vector<Ways> ways_;    ///< per pair of the rows
  std::vector<Vec3> start_;   ///< [m/s] relative velocity at the start, world frame
  std::vector<Vec3> offset_;  ///< the same in the contact's frame
  std::vector<Vec3> lambda_;  ///< [N s] in the contact's frame
  std::vector<Vec3> guess_;   ///< the part of lambda_ whose effect the implicit step contains
  std::vector<double> impulse_, position_correction_;
  std::vector<Vec3> force_on_a_;
  // Workspace.
  std::vector<std::unique_ptr<Map>> map_;  ///< per part, of the current point
  std::array<std::vector<double>, 3> force_, answer_;
  std::vector<ProjectedGaussSeidel::Entry> entries_;
  std::vector<std::size_t> first_mode_;
};

}  // namespace brim
