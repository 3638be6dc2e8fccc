#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "brim/contact/contact_set.h"
#include "brim/contact/cube_contacts.h"
#include "brim/math/types.h"
#include "brim/response/edge_points.h"
#include "brim/response/moved_rows.h"
#include "brim/response/node_places.h"
#include "brim/response/patch_model.h"

namespace brim {

struct ConstraintOptions {
  double dt = 0.0;            ///< [s]
  double bounce_speed = 0.0;  ///< [m/s] slower approaches do not bounce
  bool every_node = false;    ///< one point per contact node: the full set that patches are measured against
  /// Two solids, where a single pair of them is gathered: corners of flat faces stand at their edges.
  const CubeSide *side_a = nullptr, *side_b = nullptr;
};

/// What the constraint response needs of a pair besides its contacts.
struct ConstraintPair {
  bool constrained = false;           ///< false: the pair is not this response's
  double friction = 0.0;              ///< [-] Coulomb coefficient
  double restitution = 0.0;           ///< [-] e, 0 to 1
  bool rigid = false;                 ///< neither part deforms: few points per patch carry every force and torque
  FixedPart fixed = FixedPart::None;  ///< where the other one deforms
};

/// Constraint response (paper, section 4.3): points of contact whose gap may not become negative, each with a normal
/// and a target for the relative normal velocity u. docs/constraint.md derives the formulas.
///
/// The paper's row ∇ρ_a·δ_a + ∇ρ_b·δ_b >= ρ̄ is taken in lengths, where it holds for any overlap: with the distances d
/// that the densities stand for (ramp inverted), the gap φ = d_a + d_b and the normal n, it reads φ + n·(δ_a − δ_b) >=
/// 0.
///
/// Nodes of a pair are gathered to patches of like normal, few points each. The first point is where φ is least, by a
/// quadratic model of φ (its gradient and curvature are those of the densities); where neither part deforms, up to four
/// corners of the flat part of the patch carry torques, and what lies nearer than the model says (a ring on a plane is
/// no quadric) is modelled again, piece by piece. With u0 and u1 the normal velocities at the start and of the
/// motion without this contact, a = (u1 − u0)/dt, and a touch at τ = φ/|u1|:
///   no bounce   u >= −max(0, φ − 0.005 h)/dt, and overlap is pushed out by a displacement that is no velocity
///               (between rigid parts whose gaps are read off nodes 0.05 h, and overlap beyond 0.1 h alone)
///   bounce      u >= e |u0 + a (dt/2 + τ)| + a (dt/2 − τ), at least 0, and the way of the step is the broken
///   parabola's
class Constraint {
 public:
  /// Gathers the contacts to points.
  /// @param normals  unit, towards a, one per contact
  /// @param pairs    one per pair of the contacts
  /// @param gathered rows of other pairs, which are gathered already
  void gather(const ContactSet& contacts, std::span<const Vec3> normals, std::span<const ConstraintPair> pairs,
              const ConstraintOptions& options, const GatheredRows& gathered = {});
  /// The points as contacts, depth = −φ; pairs without points have empty ranges.
  const ContactSet& points() const { return points_; }
  /// The same, to be placed where both sides' maps are to be made: the gaps along the normals stay.
  ContactSet& points() { return points_; }
  std::span<const Vec3> normals() const { return normal_; }
  std::span<const double> friction() const { return friction_; }
  /// Where friction acts, [m]: at the points, or within the patch whose corners they are (rows between rigid frames).
  std::span<const Vec3> grips() const { return grip_; }
  /// Curvatures of the two surfaces at the points that gather has found itself, [1/m].
  struct Bend {
    Mat3 a = Mat3::Zero(), b = Mat3::Zero();
  };
  std::span<const Bend> bends() const { return bend_; }

  /// @param start, free  [m/s] relative velocity a − b at each point: at the start, and of the motion without contact
  void set_targets(const ConstraintOptions& options, std::span<const Vec3> start, std::span<const Vec3> free);
  /// Least normal velocity at the end of the step, and on the mean over the step, [m/s].
  std::span<const double> velocity_targets() const { return velocity_target_; }
  std::span<const double> position_targets() const { return position_target_; }
  /// Sets the velocity after an impact that others pass on: where impacts follow each other within the step.
  /// @param hit  [m/s] the velocity with which the point was hit, negative; 0: it was not
  void set_rebound(std::size_t c, double hit, double velocity, double dt);
  std::span<const double> restitution() const { return restitution_; }
  /// True when some contact bounces within the step.
  bool bounces() const { return bounces_; }
  /// True when some way is not what the velocity at the end makes of it.
  bool targets_differ() const { return targets_differ_; }

 private:
  void gather_pair(const ContactSet& contacts, std::span<const Vec3> normals, const ContactPair& pair,
                   const ConstraintPair& law, const ConstraintOptions& options);
  void take_rows(const PairRows& pair, std::span<const RowPoint> rows);
  /// Patches of small reach, for parts that deform; patches as far as they hang together, for parts that do not.
  void gather_soft(const ContactSet& contacts, std::span<const Vec3> normals, const ContactPair& pair,
                   const ConstraintPair& law);
  void gather_stiff(const ContactSet& contacts, std::span<const Vec3> normals, const ContactPair& pair,
                    const ConstraintPair& law, const ConstraintOptions& options);
  /// @param nodes  deepest first
  void add_patch(const ContactSet& contacts, std::span<const Vec3> normals, const ContactPair& pair,
                 const ConstraintPair& law, const ConstraintOptions& options, std::span<const std::size_t> nodes);
  /// True where a node lies over the rim of a face, within the side face's ramp, and tells hardly more than the gap of
  /// the face: next to a row's nodes with a normal like its own.
  bool at_rim_of_face(const ContactSet& contacts, std::span<const Vec3> normals, const ContactPair& pair,
                      std::size_t c) const;
  /// True where a patch's nodes lie at the edge of a face, so that the quadric of their gaps would fall on towards its
  /// middle: where it bends, and a flat node within two voxels of its point of least gap has a smaller gap than it
  /// foretells.
  bool at_edge_of_face(const ContactSet& contacts, const PatchModel& model, double h) const;
  /// Corners of the flat part of the nodes in rest_. @param first  of the patch's points  @param center  the model's
  void add_corners(const ContactSet& contacts, const ContactPair& pair, const ConstraintPair& law,
                   const ConstraintOptions& options, const PatchModel& model, std::size_t first, std::size_t center);
  /// Lets friction at corners act where its torque is that of an even pressure (friction_radius.h).
  /// @param first  of the corners
  void place_friction(const ContactSet& contacts, const PatchModel& model, std::size_t first);
  /// Sees to it that no node overlaps more than the points say: the sum of the distances to two surfaces is never less
  /// than the gap between them, wherever it is read. @param first  of the pair's points
  void deepen(const ContactSet& contacts, std::span<const Vec3> normals, const ContactPair& pair,
              const ConstraintPair& law, std::size_t first);
  void remove_point(std::size_t i);
  void add_point(const ContactSet& contacts, std::size_t c, const Vec3& x, const Vec3& n, double gap,
                 const ConstraintPair& law, const Bend& bend);

  ContactSet points_;
  std::vector<Vec3> normal_, grip_;
  std::vector<double> friction_, restitution_;
  std::vector<std::uint8_t> off_nodes_;  ///< per pair of points_: its gaps are known as well as nodes tell them
  std::vector<Bend> bend_;
  std::vector<double> velocity_target_, position_target_;
  std::vector<double> touch_time_;  ///< [s] from the start of the step to the touch; 0 where it touches already
  bool targets_differ_ = false, bounces_ = false;
  std::vector<std::size_t> order_, patch_, rest_, around_, flat_;
  std::vector<std::uint8_t> taken_;
  PatchFitter fitter_;
  EdgePoints edges_;
  NodePlaces place_;
};

}  // namespace brim
