#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "brim/contact/contact_set.h"
#include "brim/contact/cube_contacts.h"
#include "brim/math/types.h"
#include "brim/response/edge_points.h"
#include "brim/response/moved_rows.h"
#include "brim/response/node_places.h"
#include "brim/response/patch_model.h"
#include "brim/response/round_gap.h"
#include "brim/response/round_impact.h"

namespace brim {

struct ConstraintOptions {
  double dt = 0.0;            ///< [s]
  double bounce_speed = 0.0;  ///< [m/s] slower approaches do not bounce
  bool every_node = false;    ///< one point per contact node: the reference that patches are compared with
  /// The two solids, when a single pair is gathered: corners of flat faces are carried to their edges.
  const CubeSide *side_a = nullptr, *side_b = nullptr;
};

/// Parameters of a pair for the constraint response, besides its contacts.
struct ConstraintPair {
  bool constrained = false;           ///< false: another response handles the pair
  double friction = 0.0;              ///< [-] Coulomb coefficient
  double restitution = 0.0;           ///< [-] e, 0 to 1
  bool rigid = false;                 ///< neither part deforms: few points per patch carry the full force and torque
  FixedPart fixed = FixedPart::None;  ///< when the other part deforms
};

/// Constraint response (paper, section 4.3): contact points whose gap may not become negative, each with a normal and a
/// target for the relative normal velocity u. docs/constraint.md derives the formulas.
///
/// The paper's row ∇ρ_a·δ_a + ∇ρ_b·δ_b >= ρ̄ is written in lengths, where it holds for any overlap: with the distances
/// d from the inverted ramp, the gap φ = d_a + d_b and the normal n it reads φ + n·(δ_a − δ_b) >= 0.
///
/// Nodes of a pair with like normals form patches of a few points each. The first point is the minimum of a quadratic
/// model of φ (gradient and curvature from the densities). Between rigid parts up to four corners of the flat part of
/// the patch carry torques, and nodes with smaller gaps than the model predicts (a ring on a plane is no quadric) get
/// models of their own, piece by piece. With the normal velocities u0 at the start and u1 of the motion without this
/// contact, a = (u1 − u0)/dt, and the first contact at τ, φ + u0 τ + ½ a τ² = 0:
///   no bounce   u >= −max(0, φ − 0.005 h)/dt; overlap beyond 0.005 h is removed by position correction
///               (rigid parts with gaps read at nodes: 0.05 h, and overlap beyond 0.1 h)
///   bounce      u >= e |u0 + a τ| + a (dt − τ), at least 0; the displacement of the step follows the broken parabola
///   two round surfaces: as a bounce, with e = 0 too, as their normal is that of the moment τ
class Constraint {
 public:
  /// Gathers the contacts into points.
  /// @param normals  unit, towards a, one per contact
  /// @param pairs    one per pair of the contacts
  /// @param gathered rows of other pairs, gathered already
  void gather(const ContactSet& contacts, std::span<const Vec3> normals, std::span<const ConstraintPair> pairs,
              const ConstraintOptions& options, const GatheredRows& gathered = {});
  /// The points as contacts with depth −φ; pairs without points have empty ranges.
  const ContactSet& points() const { return points_; }
  /// The same, to be moved to where the maps of both sides are made; the gaps along the normals stay.
  ContactSet& points() { return points_; }
  std::span<const Vec3> normals() const { return normal_; }
  std::span<const double> friction() const { return friction_; }
  /// Points where friction acts, [m]: the points, or places inside the patch whose corners they are (between rigid
  /// parts).
  std::span<const Vec3> grips() const { return grip_; }
  /// Moves the points g of friction of flat faces that slide so that, loaded as the corners x are, they have the same
  /// centre: Σ N_i g_i = Σ N_i x_i. Friction then turns no body that slides straight, wherever its weight lies on its
  /// base. (What sticks is held alike at any points.)
  /// @param force  force or impulse on a; shape (points)  @param pairs  nonzero for those whose friction may move
  /// @param way    [m] by which each point of friction moves, shape (points)
  /// @return false when friction has its centre already: no point moves
  bool center_friction(std::span<const Vec3> force, std::span<const std::uint8_t> pairs, std::vector<Vec3>& way);
  /// Curvatures of the two surfaces at the points, [1/m]; of gathered rows where they are convex.
  struct Bend {
    Mat3 a = Mat3::Zero(), b = Mat3::Zero();
  };
  std::span<const Bend> bends() const { return bend_; }
  /// True when gaps and curvatures of a pair of points() are read at grid nodes, not from formulas.
  bool off_nodes(std::size_t pair) const { return off_nodes_[pair] != 0; }
  /// Where the two surfaces are round, at the only point of a gathered pair.
  std::span<const RoundContact> round() const { return round_; }
  /// Places a point where its surfaces will touch: friction acts there too.
  void place(std::size_t c, const Vec3& point, const Vec3& normal, double gap);

  /// @param start, free  [m/s] relative velocity a − b at each point: at the start, and of the motion without contact
  /// @param lift  [m/s] normal velocity at the end of the step of what follows a curved surface, in addition
  void set_targets(const ConstraintOptions& options, std::span<const Vec3> start, std::span<const Vec3> free,
                   std::span<const double> lift = {});
  /// Lower bounds of the normal velocity at the end of the step, and of its mean over the step, [m/s].
  std::span<const double> velocity_targets() const { return velocity_target_; }
  std::span<const double> position_targets() const { return position_target_; }
  /// Sets the velocity after an impact passed on by other bodies, when impacts follow each other within the step.
  /// @param hit  [m/s] normal velocity before the impact, negative; 0: no impact
  void set_rebound(std::size_t c, double hit, double velocity, double dt);
  std::span<const double> restitution() const { return restitution_; }
  /// True when some contact bounces within the step.
  bool bounces() const { return bounces_; }
  /// True when some contact is hit within the step, and its displacement is that of a path with a bend.
  bool breaks() const { return breaks_; }
  /// [s] from the start of the step until each contact is hit; 0 where it is not, or touched already.
  std::span<const double> touch_times() const { return touch_time_; }
  /// True when the targets of position and velocity differ.
  bool targets_differ() const { return targets_differ_; }

 private:
  /// Largest sine of the angle between a model's normal and those of its nodes: nodes farther along the arc of a hollow
  /// have a model of their own.
  static constexpr double kAlongArc = 0.45;
  /// [voxels] corners closer to another point than this are redundant.
  static constexpr double kApart = 1.0;

  void gather_pair(const ContactSet& contacts, std::span<const Vec3> normals, const ContactPair& pair,
                   const ConstraintPair& law, const ConstraintOptions& options);
  void take_rows(const PairRows& pair, std::span<const RowPoint> rows);
  /// Small patches for deformable parts (gather_soft); patches over all connected nodes for rigid parts (gather_rigid).
  void gather_soft(const ContactSet& contacts, std::span<const Vec3> normals, const ContactPair& pair,
                   const ConstraintPair& law);
  void gather_rigid(const ContactSet& contacts, std::span<const Vec3> normals, const ContactPair& pair,
                    const ConstraintPair& law, const ConstraintOptions& options);
  /// @param nodes  deepest first
  void add_patch(const ContactSet& contacts, std::span<const Vec3> normals, const ContactPair& pair,
                 const ConstraintPair& law, const ConstraintOptions& options, std::span<const std::size_t> nodes);
  /// True for a node over the rim of a face, within the ramp of the side face, whose gap hardly exceeds that of a node
  /// of a row next to it with a similar normal.
  bool at_rim_of_face(const ContactSet& contacts, std::span<const Vec3> normals, const ContactPair& pair,
                      std::size_t c) const;
  /// True where a patch's nodes lie at the edge of a face, so that the quadric of their gaps would drop towards its
  /// middle: the model is curved, and a flat node within two voxels of its minimum has a smaller gap than it predicts.
  bool at_edge_of_face(const ContactSet& contacts, const PatchModel& model, double h) const;
  /// Adds the corners of the flat part of the nodes in rest_; along round directions they lie at the least gap.
  /// @param first  of the patch's points  @param center  the model's
  void add_corners(const ContactSet& contacts, const ContactPair& pair, const ConstraintPair& law,
                   const ConstraintOptions& options, const PatchModel& model, const RoundDirections& round,
                   std::size_t first, std::size_t center);
  /// Moves the friction points of the corners so that their torque is that of an even pressure (friction_radius.h).
  /// @param first  of the corners
  void place_friction(const ContactSet& contacts, const PatchModel& model, std::size_t first);
  /// Deepens points so that no node overlaps more than they do: the sum of the distances to two surfaces is, at any
  /// place, at least the gap between them. @param first  of the pair's points
  void deepen(const ContactSet& contacts, std::span<const Vec3> normals, const ContactPair& pair,
              const ConstraintPair& law, std::size_t first);
  void remove_point(std::size_t i);
  void add_point(const ContactSet& contacts, std::size_t c, const Vec3& x, const Vec3& n, double gap,
                 const ConstraintPair& law, const Bend& bend);

  ContactSet points_;
  std::vector<Vec3> normal_, grip_;
  std::vector<double> friction_, restitution_;
  std::size_t by_formula_ = 0;           ///< points of the pair being gathered that find_round_point found
  std::vector<std::uint8_t> off_nodes_;  ///< per pair of points_: nonzero when its gaps are read at grid nodes
  std::vector<Bend> bend_;
  std::vector<RoundContact> round_;
  std::vector<double> velocity_target_, position_target_;
  std::vector<double> touch_time_;
  bool targets_differ_ = false, bounces_ = false, breaks_ = false;
  std::vector<std::size_t> order_, patch_, rest_, around_, flat_;
  std::vector<std::uint8_t> taken_;
  bool fits_ = false;  ///< the surfaces of the pair being gathered lie along each other (fit_each_other)
  PatchFitter fitter_;
  EdgePoints edges_;
  NodePlaces place_;
};

}  // namespace brim
