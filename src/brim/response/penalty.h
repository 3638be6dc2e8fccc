#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "brim/contact/contact_set.h"
#include "brim/contact/cube_contacts.h"
#include "brim/math/types.h"
#include "brim/response/friction_share.h"
#include "brim/response/hardening.h"

namespace brim {

struct PenaltyOptions {
  double dt = 0.0;              ///< [s]
  double damping = 0.0;         ///< [s] β, stiffness-proportional damping
  double friction_speed = 0.0;  ///< [m/s] ε of the regularised Coulomb law, > 0
  double slack = 0.0;           ///< [m] gap that may close in the step even if the start velocities do not close it
  double release_speed = 0.0;   ///< [m/s] separation speed above which a node in tension is released
};

/// Parameters of a pair for the penalty response, besides its contacts.
struct PairState {
  double stiffness = 0.0;               ///< [Pa] k
  double friction = 0.0;                ///< [-] Coulomb coefficient
  Vec3 mean_velocity_a = Vec3::Zero();  ///< [m/s] mean velocity of each part
  Vec3 mean_velocity_b = Vec3::Zero();
  /// Sides that conform to the other, as fluids do: if only one does, normals are the other's, unsmoothed.
  std::array<bool, 2> conforming = {false, false};
  bool rigid = false;   ///< neither part deforms: no node moves without all the others
  bool filled = false;  ///< one part's own pressure carries the normal load: this response adds friction only
  /// [1/kg] of the two bodies; 0 of one that is held by more than contact.
  std::array<double, 2> inverse_mass = {0.0, 0.0};
  std::array<std::int32_t, 2> body = {0, 1};  ///< numbers of the two bodies
  bool fixed = false;                         ///< one of the bodies does not move
  bool firm = false;    ///< one of the bodies does not move, or does not yield to pressure while the other does
  bool guide = false;   ///< one of the parts is a rigid body, or does not move, and the other deforms
  bool sheet = false;   ///< one of the parts is a sheet, or a fluid
  bool balls = false;   ///< one of the parts consists of balls that turn
  double growth = 1.0;  ///< [-] stiffness at full overlap over k (hardening.h)
  /// Of two solids both, if their centres hardly move past each other; the convex solid that a sheet or grains lie on;
  /// else null.
  std::array<const CubeSide*, 2> solids = {};
};

/// Action of a link, in the place of a contact: a force at the start of the step and the matrix across n nᵀ + along 1
/// of the implicit step, [N·s²/m]. Links are the last pairs of a contact set.
struct Bond {
  Vec3 force = Vec3::Zero();  ///< [N] on a: f − (dt k + d) v at the start
  Vec3 n = Vec3::UnitZ();     ///< unit
  double across = 0.0, along = 0.0;
  bool one_way = false;  ///< acts along n on a only; released for the step when it would pull the other way
  bool stops = false;    ///< one-way link that is a joint's limit
  bool waits = false;    ///< one-way link that joins only once a solve's motion calls for it, not in the first solve
};

/// Penalty response (paper, section 4.2): contacts become forces at their points, equal and opposite on the two parts,
/// and a positive semi-definite stiffness and friction for the implicit step.
///
///   f_a = k h³ ρ̄ (ĝ·n) n,   ĝ = (1−α) ∇ρ_a − α ∇ρ_b              (equation 2; α = 1/2 is the paper's symmetric form)
///   α = κ_a / (κ_a + κ_b): the direction comes from the flatter of the two parts, κ their tangential curvature
///   K = k h³ (ĝ·n)² n nᵀ                                     (equation 3, definite part; n smoothed over 3h)
///   where a pair hardens (PairState::growth), φ'(ρ̄) in the place of ρ̄, and k φ''(ρ̄) of k in K (hardening.h)
///   friction: −μ N v_t / max(|v_t|, ε), N the predicted normal force
///
/// The rate of overlap in the right-hand side is taken in the frame that moves with the patch (docs/numerics.md):
/// motion that only carries the patch along is no compression and gets no force, so rolling is not braked.
///
/// Between rigid solids that fit each other (fitting_solids.h) normals are not smoothed and rates follow the solids'
/// motion: forces are then those of the overlap's energy.
class Penalty {
 public:
  Penalty();
  ~Penalty();
  /// Finds only the normals, for points placed by them before the maps are made; begin then keeps them.
  void find_normals(const ContactSet& contacts, std::span<const PairState> pairs);
  /// After find_normals: replaces the normal of contact c. @param n  unit, towards a
  void set_normal(std::size_t c, const Vec3& n) { normal_[c] = n; }
  /// @param velocity_a, velocity_b  [m/s] of each part's material at every contact point, at the start of the step
  void begin(const ContactSet& contacts, std::span<const PairState> pairs, const PenaltyOptions& options,
             std::span<const Vec3> velocity_a, std::span<const Vec3> velocity_b);

  /// Force on part a of each contact for the right-hand side, [N]: f − (dt + β) K v − friction, at the start
  /// velocities.
  void right_hand_side(std::span<Vec3> force) const;
  /// force = (dt (dt + β) K + dt C) Δ for relative velocity changes Δ = Δv_a − Δv_b.
  void apply(std::span<const Vec3> delta, std::span<Vec3> force) const;
  /// The same at contact c.
  Vec3 apply(std::size_t c, const Vec3& delta) const {
    const Action& a = action_[c];
    return (a.across * a.n.dot(delta)) * a.n + a.viscosity * delta;
  }
  /// The 3x3 matrix of apply at contact c, plus the stiffness from set_pressed: for preconditioners.
  Mat3 block(std::size_t c) const;

  /// For contacts of filled pairs, after begin. set_pressed: normal stiffness in the step's system, [N·s²/m], which
  /// another response answers, and the drag of a fluid that sticks to the surface, [N s/m]. set_load: normal force for
  /// friction, [N].
  void set_pressed(std::size_t c, double stiffness, double drag) { pressed_[c] = stiffness, drag_[c] = drag; }
  void set_load(std::size_t c, double load);
  /// [N] expected normal force at contact c, after begin; 0 when it is inactive.
  double expected_load(std::size_t c) const { return active_[c] ? std::max(0.0, load_[c]) : 0.0; }
  /// After begin: sets the actions of the links, the last contacts. @param bonds  shape (links)
  void set_bonds(std::vector<Bond> bonds);
  /// Replaces the forces of the actions of the links, and nothing else of them.
  void set_bond_forces(std::span<const Bond> bonds);

  /// After a solve: releases nodes that would pull, and sets friction to the predicted loads.
  /// @param delta  relative velocity changes found by the solve
  /// @return resulting change of the contact forces over the sum of the loads: an estimate of the change by another
  /// solve
  double update_loads(const ContactSet& contacts, std::span<const Vec3> delta);

  /// Save and restore what update_loads changes, for use when the solve before it is kept: forces are reported as they
  /// acted.
  void keep_loads();
  void take_back_loads();

  /// Forces on part a over the step, [N], given the final relative velocity changes.
  void forces(std::span<const Vec3> delta, std::span<Vec3> normal, std::span<Vec3> friction) const;

  /// True for a pair of which one part guides the other, which deforms, along its surface.
  bool guides(std::size_t pair) const { return pairs_[pair].guide; }
  /// Nonzero for contacts that are active in the coming solve, shape (contacts).
  std::span<const std::uint8_t> acting() const { return active_; }
  /// True when no contact can have a force in this step.
  bool idle() const { return idle_; }
  /// After rows have changed what a solve found: releases limits of joints that pull now.
  /// @return true when one has been released: the solve is to be made again  @param delta  [m/s] of all contacts
  bool release_stops(std::span<const Vec3> delta);
  /// True when a link is a joint's limit.
  bool has_stops() const {
    return std::ranges::any_of(bonds_, [](const Bond& b) { return b.stops; });
  }
  /// True when no contact can be released or have friction: the result of the next solve is final.
  bool settled() const { return settled_; }
  /// Smoothed unit normals, towards a, one per contact; available after begin.
  std::span<const Vec3> normals() const { return normal_; }
  /// Σ ½ k h³ ρ̄², or k h³ φ(ρ̄) where a pair hardens, [J].
  double energy() const { return energy_; }

 private:
  /// across n nᵀ + viscosity 1: matrix of a contact in the implicit step; zero when inactive.
  struct Action {
    Vec3 n;
    double across, viscosity;
  };
  void settle_actions();
  std::size_t first_bond() const { return force_.size() - bonds_.size(); }
  /// Force on a of a link over the step, [N]. @param delta  relative velocity change
  Vec3 bond_force(std::size_t i, const Vec3& delta) const;
  /// Releases one-way links that would act the wrong way and activates waiting ones.
  /// @param changed, total  [N] added to
  void update_bonds(std::span<const Vec3> delta, double& changed, double& total);
  void choose_normals(const ContactSet& contacts, std::span<const PairState> pairs);
  /// Of a sheet or grains on a convex solid: the gradient of the solid's own distance at the point. Within a step of an
  /// edge the densities' gradients lean outwards, and two pads would shoot out what is between them.
  /// @param everywhere  else only where the solid is even: at its edges a sheet's own direction counts too
  void take_exact_normals(const CubeSide& solid, bool is_b, const ContactSet& contacts, const ContactPair& pair,
                          bool everywhere);
  /// Takes the normals of the surface that a conforming side lies against.
  void take_normals_of(bool side_b, const ContactSet& contacts, const ContactPair& pair);
  /// Curvature of a patch as the harmonic mean over its nodes: a patch with a flat middle counts as flat, whatever its
  /// edges.
  void bend_of_patch(const ContactSet& contacts, const ContactPair& pair, std::size_t p);
  /// Forces and stiffnesses at the start of the step.
  void start_forces(const ContactSet& contacts, std::span<const Vec3> velocity_a, std::span<const Vec3> velocity_b);
  void advect_rates(const ContactSet& contacts, std::span<const Vec3> velocity_a, std::span<const Vec3> velocity_b);
  void advect_rates_of(std::size_t p, const ContactSet& contacts, std::span<const Vec3> velocity_a,
                       std::span<const Vec3> velocity_b);
  /// Slopes that meet the motions of a pair at a contact: the common direction, and how far each part's own is from it.
  struct Slopes {
    Vec3 common, a, b;
  };
  Slopes slopes_at(std::size_t c, std::size_t p, const ContactSet& contacts) const;
  /// Friction from the loads at the start of the step; a node without overlap is active if it will overlap.
  void start_friction(const ContactSet& contacts);
  void start_friction_of(std::size_t p, const ContactSet& contacts);
  double overlap_energy(const ContactSet& contacts) const;
  /// @param stick  [m/s] slip below which friction is viscous
  void set_friction(std::size_t c, double load, const Vec3& tangential, double stick);
  /// Tangential relative velocity of a contact, [m/s].
  Vec3 slip_after(std::size_t c, std::span<const Vec3> delta) const;
  /// Load-weighted mean slip of a pair, [m/s]. @param delta  velocity changes, empty at the start
  Vec3 mean_slip(const ContactPair& pair, std::span<const Vec3> delta) const;
  /// Forecast of a pair's slip: all nodes change by (ratio - 1) mean between rigid parts, each by (ratio - 1) of its
  /// own slip where a part deforms.
  struct SlipForecast {
    double ratio = 1.0;        ///< slip to assume in the next solve, over the slip found by the last
    Vec3 mean = Vec3::Zero();  ///< [m/s] mean slip found, between rigid parts
  };
  SlipForecast expected_slip(std::size_t p);
  /// What a solve has found of a pair's slip.
  struct SlipFound {
    Vec3 mean = Vec3::Zero();           ///< [m/s] load-weighted
    double speed = 0.0;                 ///< [m/s] its size; where a part deforms, the load-weighted mean of the speeds
    double friction = 0.0, most = 0.0;  ///< [N] friction that has opposed the slip, and its limit
    Vec3 beyond = Vec3::Zero();         ///< [N] friction of a rigid pair beyond its limit, along the mean slip
  };
  /// @param share  pair's net load over the sum of its loads
  SlipFound find_slip(const ContactPair& pair, std::size_t p, std::span<const Vec3> delta, double share) const;
  /// How friction beyond its limits and the pull of what is let go, once they are gone, change the velocities of the
  /// bodies.
  void push_bodies();

  /// Results of the step's solves for a pair's slip.
  struct SlipHistory {
    double friction_before = 0.0;  ///< [N] friction in the last solve
    double found_before = 0.0;     ///< [m/s] mean slip found by it
    int solves = 0;
    double stick = 0.0;    ///< [m/s] slip below which friction is viscous
    double assumed = 0.0;  ///< [m/s] mean slip assumed in the last solve
    /// Solves that assumed too small a slip (tight) and too large a one (loose); `assumed` is 0 where there was no such
    /// solve.
    struct Side {
      double assumed = 0.0;
      double excess = 0.0;  ///< logarithm of the slip found over the one assumed
    } tight, loose;
    /// Stores the last solve as one of the two sides. @param too_much  friction exceeded its limit
    /// @return [m/s] `next`, or if it lies outside the two sides, the slip between them at which found = assumed
    double keep_between(double next, double found, bool too_much);
  };
  /// State of a pair in a step, besides what it is given.
  struct Patch {
    bool fits = false;                        ///< rigid solids that fit each other
    std::array<double, 2> bend = {0.0, 0.0};  ///< curvature of each part, 0 flat to 1
    Hardening hardening;                      ///< force over overlap
    SlipHistory slip;
    // In update_loads:
    FrictionShare share;         ///< of the loads, for friction
    Vec3 let_go = Vec3::Zero();  ///< [N] force on a that goes with the nodes of a pulling patch
    SlipFound found;
  };

  struct Workspaces;
  std::unique_ptr<Workspaces> workspaces_;
  PenaltyOptions options_;
  double energy_ = 0.0;
  bool normals_found_ = false;  ///< by find_normals, for the next begin
  bool idle_ = true, settled_ = false;
  // Per contact:
  std::vector<Vec3> direction_;        ///< ĝ, [1/m]
  std::vector<Vec3> normal_;           ///< n, unit
  std::vector<Vec3> force_;            ///< f_a at the start, along n, [N]
  std::vector<Vec3> relative_;         ///< v_a − v_b at the start, [m/s]
  std::vector<double> rate_;           ///< −dρ̄/dt seen by the travelling patch, [1/s]
  std::vector<double> stiffness_;      ///< k φ'' h³ (ĝ·n)², [N/m]
  std::vector<double> implicit_time_;  ///< [s] dt + β in overlap, dt before it
  std::vector<std::uint8_t> active_;   ///< 0: no force in this step
  std::vector<std::uint8_t> kept_active_;
  std::vector<double> kept_viscosity_;
  std::vector<double> scale_;               ///< k φ'' h³ (ĝ·n), [N]
  std::vector<double> load_;                ///< predicted normal force, [N]
  std::vector<double> friction_viscosity_;  ///< C, friction per speed, [N·s/m]
  std::vector<double> mu_;
  std::vector<double> pressed_, drag_;  ///< set_pressed
  std::vector<Action> action_;
  std::vector<Bond> bonds_;  ///< of the links, the last contacts
  // Per pair:
  std::vector<PairState> pairs_;  ///< given to begin; their solids may be gone after it
  std::vector<Patch> patches_;
  std::vector<Vec3> pushed_;  ///< [m/s] per body (push_bodies)
};

}  // namespace brim
