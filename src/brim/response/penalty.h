#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "brim/contact/contact_set.h"
#include "brim/math/types.h"

namespace brim {

struct PenaltyOptions {
  double dt = 0.0;              ///< [s]
  double damping = 0.0;         ///< [s] β, stiffness-proportional damping
  double friction_speed = 0.0;  ///< [m/s] ε of the regularised Coulomb law, > 0
  double slack = 0.0;           ///< [m] gap that may close in the step although the start velocities do not say so
  double release_speed = 0.0;   ///< [m/s] separation above which a node in tension lets go
};

/// What the response needs of a pair besides its contacts.
struct PairState {
  double stiffness = 0.0;               ///< [Pa] k
  double friction = 0.0;                ///< [-] Coulomb coefficient
  Vec3 mean_velocity_a = Vec3::Zero();  ///< [m/s] velocity with which each part as a whole travels
  Vec3 mean_velocity_b = Vec3::Zero();
  /// Sides that take the shape of the other, as fluids do: if it is one only, normals are the other's, unsmoothed.
  std::array<bool, 2> conforming = {false, false};
  bool rigid = false;         ///< neither part deforms: no node can be driven without all the others
  bool filled = false;        ///< one part's own pressure answers the other: of this response there is friction alone
  double inverse_mass = 0.0;  ///< [1/kg] sum of those of the two bodies
  bool fixed = false;         ///< one of them does not move
};

/// What a link does in the place of a contact: a force at the start of the step, and the matrix
/// across n nᵀ + along 1 of the implicit step, [N·s²/m]. Links have the pairs at the end of a contact set.
struct Bond {
  Vec3 force = Vec3::Zero();  ///< [N] on a: f − (dt k + d) v at the start
  Vec3 n = Vec3::UnitZ();     ///< unit
  double across = 0.0, along = 0.0;
  bool one_way = false;  ///< acts along n on a only: where it would pull the other way it is let go for the step
  bool waits = false;    ///< of what acts one way: not in the first solve, only where the solve's motion calls for it
};

/// Penalty response (paper, section 4.2): contacts become forces at their points, equal and opposite on the two parts,
/// and a positive semi-definite stiffness and friction for the implicit step.
///
///   f_a = k h³ ρ̄ (ĝ·n) n,   ĝ = (1−α) ∇ρ_a − α ∇ρ_b              (equation 2; α = 1/2 is the paper's symmetric form)
///   α = κ_a / (κ_a + κ_b): the direction comes from the flatter of the two parts, κ their tangential curvature
///   K = k h³ (ĝ·n)² n nᵀ                                     (equation 3, definite part; n smoothed over 3h)
///   friction: −μ N v_t / max(|v_t|, ε), N the predicted normal force
///
/// The rate of the overlap in the right-hand side is taken in the frame that travels with the patch (docs/numerics.md):
/// what merely carries the patch along is no compression and gets no force, so that rolling is not braked.
class Penalty {
 public:
  Penalty();
  ~Penalty();
  /// Finds the normals alone, for points that are placed by them before the maps are made; begin then keeps them.
  void find_normals(const ContactSet& contacts, std::span<const PairState> pairs);
  /// After find_normals: another normal of contact c. @param n  unit, towards a
  void set_normal(std::size_t c, const Vec3& n) { normal_[c] = n; }
  /// @param velocity_a, velocity_b  [m/s] matter of each part at every contact point, at the start of the step
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
  /// The 3x3 matrix of apply at contact c, and what set_pressed has said besides: for preconditioners.
  Mat3 block(std::size_t c) const;

  /// For contacts of filled pairs, after begin: stiffness along the normal in the step's system, [N·s²/m], which
  /// another answers, and the drag of a fluid that sticks to what it touches, [N s/m]; then the normal force that
  /// friction works with, [N].
  void set_pressed(std::size_t c, double stiffness, double drag) { pressed_[c] = stiffness, drag_[c] = drag; }
  void set_load(std::size_t c, double load);
  /// [N] normal force that is expected at contact c, after begin; 0 where it does not act.
  double expected_load(std::size_t c) const { return active_[c] ? std::max(0.0, load_[c]) : 0.0; }
  /// After begin: what the last contacts do, which are links. @param bonds  shape (links)
  void set_bonds(std::vector<Bond> bonds);

  /// After a solve: lets go of nodes that would pull, and sets the friction to the predicted loads.
  /// @param delta  relative velocity changes found by the solve
  /// @return change of the contact forces by it, over the sum of the loads: how far another solve would differ
  double update_loads(const ContactSet& contacts, std::span<const Vec3> delta);

  /// What update_loads changes, to be taken up again where the solve before it is kept: forces are told as they acted.
  void keep_loads();
  void take_back_loads();

  /// Forces on part a over the step, [N], given the final relative velocity changes.
  void forces(std::span<const Vec3> delta, std::span<Vec3> normal, std::span<Vec3> friction) const;

  /// True for a pair whose one part is fixed and guides the other, which deforms.
  bool guides(std::size_t pair) const { return fixed_[pair] != 0 && rigid_[pair] == 0; }
  /// Nonzero for contacts that act in the coming solve, shape (contacts).
  std::span<const std::uint8_t> acting() const { return active_; }
  /// True when no contact can have a force in this step: none is answered by this response.
  bool idle() const { return idle_; }
  /// True when no contact can let go or have friction: what the next solve says is final.
  bool settled() const { return settled_; }
  /// Smoothed unit normals, towards a, one per contact; known after begin.
  std::span<const Vec3> normals() const { return normal_; }
  /// Σ ½ k h³ ρ̄², [J].
  double energy() const { return energy_; }

 private:
  /// across n nᵀ + viscosity 1, what the implicit step sees of a contact; zero where it does not act.
  struct Action {
    Vec3 n;
    double across, viscosity;
  };
  void settle_actions();
  std::size_t first_bond() const { return force_.size() - bonds_.size(); }
  /// Force on a of a link over the step, [N]. @param delta  relative velocity change
  Vec3 bond_force(std::size_t i, const Vec3& delta) const;
  /// Lets go of links that act one way and would act the other, and takes up those that wait. @param changed, total [N]
  /// added to
  void update_bonds(std::span<const Vec3> delta, double& changed, double& total);
  void choose_normals(const ContactSet& contacts, std::span<const PairState> pairs);
  /// The normals of a surface that something conforming lies against.
  void take_normals_of(bool side_b, const ContactSet& contacts, const ContactPair& pair);
  /// Judges a patch by the harmonic mean of its curvature: a patch with any flat middle is flat, whatever its edges.
  void bend_of_patch(const ContactSet& contacts, const ContactPair& pair, std::size_t p);
  void advect_rates(const ContactSet& contacts, std::span<const PairState> pairs, std::span<const Vec3> velocity_a,
                    std::span<const Vec3> velocity_b);
  /// @param stick  [m/s] slip below which friction is viscous
  void set_friction(std::size_t c, double load, const Vec3& tangential, double stick);
  /// Tangential relative velocity of a contact, [m/s].
  Vec3 slip_after(std::size_t c, std::span<const Vec3> delta) const;
  /// Slip of a pair, the mean weighted by load, [m/s]. @param delta  velocity changes, none at the start
  Vec3 mean_slip(const ContactPair& pair, std::span<const Vec3> delta) const;
  /// How the slip of a pair will change: all nodes by (ratio - 1) mean between rigid parts, each by (ratio - 1) of its
  /// own where a part deforms.
  struct SlipForecast {
    double ratio = 1.0;        ///< slip that the next solve should assume, over what the last has found
    Vec3 mean = Vec3::Zero();  ///< [m/s] mean slip found, between rigid parts
  };
  /// @param share  of the loads that is the pair's net load
  SlipForecast expected_slip(const ContactPair& pair, std::size_t p, std::span<const Vec3> delta, double share);

  /// What the solves of a step have told of a pair's slip.
  struct SlipHistory {
    double friction_before = 0.0;  ///< [N] that acted in the last solve
    double found_before = 0.0;     ///< [m/s] mean slip that it left
    int solves = 0;
    double stick = 0.0;    ///< [m/s] slip below which friction is viscous
    double assumed = 0.0;  ///< [m/s] mean slip that the last solve was told
    /// Solves that were told too small a slip, and too large a one; `assumed` is none where there was no such solve.
    struct Side {
      double assumed = 0.0;
      double excess = 0.0;  ///< logarithm of the slip found over the one assumed
    } tight, loose;
    /// Takes the last solve as one of the sides. @param too_much  friction was more than there may be
    /// @return [m/s] `next`, or where it lies beside the sides, the slip between them that should be found as assumed
    double keep_between(double next, double found, bool too_much);
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
  std::vector<double> stiffness_;      ///< k h³ (ĝ·n)², [N/m]
  std::vector<double> implicit_time_;  ///< [s] dt + β in overlap, dt before it
  std::vector<std::uint8_t> active_;   ///< 0: no force in this step
  std::vector<std::uint8_t> kept_active_;
  std::vector<double> kept_viscosity_;
  std::vector<double> scale_;               ///< k h³ (ĝ·n), [N]
  std::vector<double> load_;                ///< predicted normal force, [N]
  std::vector<double> friction_viscosity_;  ///< C, friction per speed, [N·s/m]
  std::vector<double> mu_;
  std::vector<double> pressed_, drag_;  ///< set_pressed
  std::vector<Action> action_;
  std::vector<Bond> bonds_;                  ///< of the last contacts
  std::vector<SlipHistory> slip_;            ///< per pair
  std::vector<double> inverse_mass_;         ///< [1/kg] per pair
  std::vector<std::uint8_t> rigid_, fixed_;  ///< per pair
  std::vector<std::uint8_t> filled_;         ///< per pair
  std::vector<std::array<double, 2>> bend_;  ///< per pair: how bent each part is at the patch, 0 flat to 1
};

}  // namespace brim
