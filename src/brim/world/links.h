#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "brim/body/aimed_drives.h"
#include "brim/contact/contact_set.h"
#include "brim/response/penalty.h"
#include "brim/world/arc.h"
#include "brim/world/attachment.h"
#include "brim/world/matter_points.h"
#include "brim/world/step_report.h"
#include "brim/world/world_part.h"

namespace brim {

/// Springs and dampers between material points (docs/links.md), handled by the step as contacts that are never
/// released: the same products, factor, coarse modes and momentum checks. With e the error and u = e' at the start of a
/// step,
///   f_a = −k e − (dt k + d) u,   A gains Jᵀ dt (dt k + d) P J,   P = 1, n nᵀ (along the line of the two ends)
/// Joints (LinkJoint) hold a few points around their frame: fully, or only across the axis when they may slide along
/// it; forces along the coordinate act at a point off the axis. In each direction both sides take the force at one
/// point, or each at its own on the line of the force, so no torque remains. Where the ends move on arcs, as those of
/// rigid bodies do, what the arcs add to e within the sub-step counts at once (follow_arcs). Rigid links have k =
/// kRigid m / dt², m: the mass they hold. After one step an error has decayed to 1/kRigid of itself, and gravity leaves
/// an error of g dt² / kRigid. Same bits for any number of threads.  Tests: tests/world/links_test.cpp
class Links {
  struct Link;

 public:
  /// Links of a state, for Wiring.
  using List = std::vector<std::shared_ptr<Link>>;
  /// Weight of a rigid link in the system, relative to the mass it holds.
  static constexpr double kRigid = 1000.0;
  /// Largest ratio of the two sides' masses that is taken into account.
  static constexpr double kUnequal = 100.0;
  /// Swing of a solid in one sub-step, see swing_pieces; chains of them are stable up to 2.
  static constexpr double kSwing = 1.5;
  /// [rad] Turn of a solid with links in one sub-step.
  static constexpr double kSpin = 1.0;
  /// Maximum number of points for a region of a solid: a rigid part needs no more.
  static constexpr std::size_t kMostOfSolid = 16;

  /// A body at its last update, as a side of a link.
  struct Side {
    std::vector<int> parts;  ///< global part numbers; empty: space
    std::span<const double> q;
  };

  /// State of all bodies.
  struct Motion {
    std::span<const double> q, v;
    std::span<const std::size_t> first_q, first_v;

    std::span<const double> q_of(int body) const { return q.subspan(first_q[body], first_q[body + 1] - first_q[body]); }
    std::span<const double> v_of(int body) const { return v.subspan(first_v[body], first_v[body + 1] - first_v[body]); }
  };

  /// Adds a link. @param time  [s] now  @throws InputError naming the link
  /// @return its number
  int add(const Attachment& attachment, std::span<const WorldPart> parts, const Side& a, const Side& b,
          double ramp_voxels, double time);
  /// Holds a body to space temporarily by one hidden link behind all others, which is in no report and no memory.
  /// Replaces the previous one. @throws InputError
  void grab(const Attachment& attachment, std::span<const WorldPart> parts, const Side& a, double ramp_voxels,
            double time);
  void release();
  bool grabs() const { return grabs_; }
  bool empty() const { return links_.empty(); }
  std::size_t size() const { return links_.size(); }
  /// Number of links without the grabbing one, which is the last.
  std::size_t kept() const { return links_.size() - grabs_; }
  const Attachment& attachment(std::size_t i) const { return links_[i]->given; }
  /// Target of its drive, if it was set.
  const std::optional<DriveAim>& aim(std::size_t i) const { return links_[i]->aim; }
  /// Number that no other link of this world ever has.
  std::int64_t id(std::size_t i) const { return links_[i]->id; }
  /// The links without the grabbing one, and the same in their place.
  List list() const { return {links_.begin(), links_.begin() + static_cast<std::ptrdiff_t>(kept())}; }
  void set_list(const List& list);
  /// Fills in the ends of a link (Attachment::ends). Bodies must be up to date.
  void find_ends(std::size_t i, std::span<const WorldPart> parts, std::span<const double> q,
                 std::span<const std::size_t> first_q, double time);
  /// True when some link, broken or not, has an end in space.
  bool needs_space() const;
  bool broken(std::size_t i) const { return links_[i]->broken; }
  void set_broken(std::size_t i, bool broken) { links_[i]->broken = broken; }
  /// Target of a joint's drive from now on, in place of that of its description.
  /// @throws InputError where the link has no drive
  void set_drive(std::size_t i, double position, double velocity);
  /// The two body numbers of a link, −1: space.
  std::pair<int, int> bodies(std::size_t i) const { return {links_[i]->body_a, links_[i]->body_b}; }

  /// Appends the active links to the set. Bodies must be up to date. @param space  number of the part that stands for
  /// space
  /// @param longest  [s] of any sub-step. A rigid link closes an error within that time: one made in a long sub-step
  ///   and closed in a shorter one would become speed, most of all across chains that are almost straight.
  void append(std::span<const WorldPart> parts, const Motion& motion, int space, double time, double dt, double longest,
              ContactSet& set);
  /// Passes the links to the response, after its begin.
  /// @param velocity_a, velocity_b  [m/s] at all contacts
  void begin(std::span<const WorldPart> parts, const Motion& motion, const ContactSet& set,
             std::span<const Vec3> velocity_a, std::span<const Vec3> velocity_b, Penalty& response);
  /// After a solve: lets the ends of links move on the arcs of the velocities that it found.
  /// @param motion  with the velocities after the solve  @param delta  [m/s] relative changes at all contacts
  /// @return largest change of a link's error by that, over what is followed: 1 or less needs no other solve
  double follow_arcs(std::span<const WorldPart> parts, const Motion& motion, const ContactSet& set,
                     std::span<const Vec3> delta, Penalty& response);
  /// True when ends of links move on arcs: another solve may be needed.
  bool bends() const { return bends_; }
  /// Sets the coordinates of the report to those at the end of a step, and adds the energy of springs (of links, drives
  /// and limits that are not rigid) to its potential energy. Bodies must be up to date.
  /// @param time  [s] now
  void measure(std::span<const WorldPart> parts, std::span<const double> q, std::span<const std::size_t> first_q,
               double time, StepReport& report);
  /// Number of pieces of a sub-step in which the swing of solids under the pull of their links is stable: the torque of
  /// a link's force changes as its lever turns, which the sub-step's system leaves out. With κ = Σ r·f about the middle
  /// of a solid and its moment of inertia I, dt √(κ/I) may be kSwing. The fastest swing of the last tenths of a second
  /// counts: loads of a chain rise and fall within a step, and sub-steps that become longer and shorter with them feed
  /// its swing.
  double swing_pieces(double dt) const { return dt * std::max(swing_, swing_now_) / kSwing; }
  /// Number of pieces of a sub-step in which no solid with links turns by more than kSpin: then the passes of a solve
  /// find the arcs on which its links move.
  double spin_pieces(std::span<const WorldPart> parts, std::span<const double> v, std::span<const std::size_t> first_v,
                     double dt) const;
  /// Finds the swing under the forces of a solve. @param force  [N] on side a, all contacts  Bodies must be up to date.
  void find_swing(std::span<const WorldPart> parts, const ContactSet& set, std::span<const Vec3> force);
  /// Forgets what a solve has found that is taken back.
  void drop_swing() { swing_now_ = 0.0; }
  /// Remembers the length of a sub-step that ends, and the swing that was found last.
  void remember(double dt);
  /// [s] Length of the last sub-step; 0: there was none with links.
  double last_substep() const { return last_substep_; }
  /// Takes the forces and breaks links whose force is too large. @param force  [N] on side a, all contacts
  void finish(const ContactSet& set, std::span<const Vec3> force, double time, StepReport& report);

  /// Reads and removes its part of memory; keep writes it in front. Only broken links, targets that were set, the
  /// swing of pulled solids and the length of the last sub-step are stored:
  ///   memory: [−0.125, n, numbers of broken links ..., −1, for every target: link, position, velocity ..., −2, swing,
  ///            length]
  void take(std::vector<double>& memory);
  void keep(std::vector<double>& memory) const;

 private:
  /// Constraint type of a point, or the action along a joint's coordinate.
  enum class Hold { Point, Along, Across, Drive, Lower, Upper };
  static bool along_coordinate(Hold hold) { return hold == Hold::Drive || hold == Hold::Lower || hold == Hold::Upper; }
  struct Held {
    std::size_t point = 0;
    Hold hold = Hold::Point;
    double share = 1.0;       ///< of the link's stiffness
    double length = 0.0;      ///< [m] rest length, along a line
    Vec3 gap = Vec3::Zero();  ///< [m] offset of a from b at attachment, which is closed
  };
  struct Link {
    Attachment given;
    std::int64_t id = 0;
    std::optional<DriveAim> aim;  ///< of its drive, if it was set
    int body_a = -1, body_b = -1;
    std::int32_t part_a = 0, part_b = -1;  ///< −1: space
    MatterPoints a, b;
    std::vector<Held> held;
    Vec3 middle = Vec3::Zero();  ///< [m] mean of side b's points at attachment
    double start = 0.0;          ///< [s] time of attachment
    double zero = 0.0;           ///< [rad or m] coordinate computed from the joint's points at attachment
    double mass = 0.0;           ///< [kg] mass for which a rigid link is dimensioned
    double apart = 0.0;          ///< [m] error from which on a rigid link is told of
    bool broken = false, told = false;
    /// Adds a held point.
    Held& hold(std::size_t point, Hold how, double share);
    void follow(std::span<const WorldPart> parts, std::span<const double> q, std::span<const std::size_t> first_q);
  };
  /// Coordinate of a joint.
  struct Coordinate {
    Vec3 axis = Vec3::UnitZ();
    double value = 0.0;         ///< [rad or m]
    Vec3 n = Vec3::UnitZ();     ///< direction in which the acting point moves, per length
    double lever = 1.0;         ///< [m] of the acting point about the axis; 1 for sliding
    Vec3 point = Vec3::Zero();  ///< [m] acting point
  };
  /// A held point in a sub-step.
  struct Tie {
    std::size_t link = 0, held = 0;
    Vec3 error = Vec3::Zero();   ///< [m] of a against b; the stretch times n along a line
    Vec3 target = Vec3::Zero();  ///< [m/s] velocity of a moving target
    Vec3 n = Vec3::UnitZ();
    double lever = 1.0;
    Vec3 velocity = Vec3::Zero();   ///< [m/s] of a against b, at the start
    Vec3 arc = Vec3::Zero();        ///< [m] error that arises within the sub-step, as the ends move on arcs
    Vec3 first_arc = Vec3::Zero();  ///< [m] the same with the velocities of the start
  };
  static Link make(const Attachment& attachment, std::span<const WorldPart> parts, const Side& a, const Side& b,
                   double ramp_voxels, double time);
  class SideBinder;
  /// Chooses the parts that are held, but for the other side of an attachment. @return [m] points of side a
  static std::vector<Vec3> place(Link& link, std::span<const WorldPart> parts, const Side& a, const Side& b);
  /// Finds the mass for which a rigid link is dimensioned.
  static void find_mass(Link& link, std::span<const WorldPart> parts);
  /// Chooses which of the points are held, and how. @param h  [m] step of side a
  static void choose_held(Link& link, double h);
  static void hold_attachment(Link& link, double h);
  static void hold_joint(Link& link, double h);
  /// Adds the action along a joint's coordinate: drive, damping and limits.
  static void add_coordinate(Link& link);
  static std::vector<Vec3> joint_points(const LinkJoint& joint, double span);
  static Coordinate coordinate(const Link& link);
  /// Present ends of a held point, [m], the direction n that its hold means, and its error.
  static std::pair<Vec3, Vec3> stretch(const Link& link, const Held& held, const Coordinate& c, double time, Vec3& n,
                                       Vec3& error);
  /// Target of a link's drive and its rate at a time, [s].
  static std::pair<double, double> target_of(const Link& link, double time);
  /// [J] of what is elastic of a link, with its points as they were followed last.
  static double spring_energy(const Link& link, const Coordinate& c, double time);
  void break_overloaded(double time, StepReport& report);
  std::vector<Bond> bonds() const;
  /// [m/s] Velocity of a hinge's axis on a against b at the end of the sub-step, for the tie of a drive or limit. A
  /// rigid hinge closes the error at its axis within the sub-step: that motion is no turning.
  Vec3 axis_velocity(std::size_t i) const;
  /// [m] Error that arises in a tie within the sub-step because its ends move on arcs. Lines have none: the arc of a
  /// line between light nodes would add energy, as the nodes' velocities are not smooth.
  /// @param straight  [m] dt u  @param bend  [m] by which the way of a leaves that of b beside it  @param b  of side b
  Vec3 arc_of(const Tie& tie, const Vec3& straight, const Vec3& bend, const Arc& b) const;
  /// Calls take(tie, arc) for all ties. @param delta  [m/s] changes of the velocities at all contacts, or none
  template <class Take>
  void for_arcs(std::span<const WorldPart> parts, const Motion& motion, const ContactSet& set,
                std::span<const Vec3> delta, const Take& take);
  /// Finds the arcs at the velocities of the start.
  void start_arcs(std::span<const WorldPart> parts, const Motion& motion, const ContactSet& set);
  double rigid(const Link& link) const { return kRigid * link.mass / (dt_ * dt_); }
  /// Stiffness and damping along the coordinate, per length, and the force at the start. @param u  [m/s] of turning
  void drive(const Link& link, const Tie& tie, const Vec3& u, Bond& bond) const;

  List links_;  ///< shared with the states in which they exist
  std::int64_t next_id_ = 0;
  bool grabs_ = false;  ///< the last link is the grabbing one
  std::vector<Tie> ties_;
  bool bends_ = false;
  std::vector<double> arc_changes_;     ///< per link, in the last solve; −1: its arcs are not followed any more
  std::vector<Coordinate> coordinate_;  ///< per link
  double time_ = 0.0, dt_ = 0.0;
  /// [1/s] Fastest swing of solids, √(κ/I): that is remembered, and of the present sub-step.
  double swing_ = 0.0, swing_now_ = 0.0;
  double last_substep_ = 0.0;
  double closing_ = 1.0;  ///< share of a rigid link's error that this sub-step closes
};

}  // namespace brim
