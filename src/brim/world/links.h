#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "brim/contact/contact_set.h"
#include "brim/response/penalty.h"
#include "brim/world/attachment.h"
#include "brim/world/matter_points.h"
#include "brim/world/step_report.h"
#include "brim/world/world_part.h"

namespace brim {

/// Springs and dampers between points of matter (docs/links.md), carried by the step as contacts that never let go: the
/// same products, factor, coarse modes and checks of momentum. With e the error and u = e' at the start of a step,
///   f_a = −k e − (dt k + d) u,   A gains Jᵀ dt (dt k + d) P J,   P = 1, n nᵀ (along the line of the two ends)
/// Joints (LinkJoint) hold a few points around their frame: all of them, or across the axis, along which they slide;
/// what acts along the coordinate does so at a point beside the axis. In every direction both sides take the force at
/// one point, along a line each at its own: so no torque is left over. Rigid ones have k = kRigid m / dt², m the mass
/// that they hold: an error is gone after one step but for 1/kRigid, and gravity leaves one of g dt² / kRigid. Same
/// bits for any number of threads.  Tests: tests/world/links_test.cpp
class Links {
 public:
  /// How much more a rigid link weighs in the system than the mass that it holds.
  static constexpr double kRigid = 1000.0;
  /// Most times that the lighter side is taken for the heavier one's mass.
  static constexpr double kUnequal = 100.0;
  /// Most points of a region of a solid: what is rigid needs no more.
  static constexpr std::size_t kMostOfSolid = 16;

  /// The body at its last update, as a side of a link.
  struct Side {
    std::vector<int> parts;  ///< in the world's numbers; empty: space
    std::span<const double> q;
  };

  /// Takes a link in. @param time  [s] now  @throws InputError naming the link
  /// @return its number
  int add(const Attachment& attachment, std::span<const WorldPart> parts, const Side& a, const Side& b,
          double ramp_voxels, double time);
  /// Holds a body to space for a while, by one link behind all others that nobody else sees: it is in no report and in
  /// no memory. It takes the place of the one before. @throws InputError
  void grab(const Attachment& attachment, std::span<const WorldPart> parts, const Side& a, double ramp_voxels,
            double time);
  void release();
  bool grabs() const { return grabs_; }
  bool empty() const { return links_.empty(); }
  std::size_t size() const { return links_.size(); }
  /// Without the one that grabs, which is the last.
  std::size_t kept() const { return links_.size() - grabs_; }
  const Attachment& attachment(std::size_t i) const { return links_[i].given; }
  /// Fills in where the ends of a link are (Attachment::ends). Bodies must be up to date.
  void find_ends(std::size_t i, std::span<const WorldPart> parts, std::span<const double> q,
                 std::span<const std::size_t> first_q, double time);
  /// True when some link that holds has an end in space.
  bool needs_space() const;
  bool broken(std::size_t i) const { return links_[i].broken; }
  void set_broken(std::size_t i, bool broken) { links_[i].broken = broken; }
  /// @throws InputError where the link has no drive
  void set_drive(std::size_t i, double position, double velocity);
  /// The two body numbers of a link, −1: space.
  std::pair<int, int> bodies(std::size_t i) const { return {links_[i].body_a, links_[i].body_b}; }

  /// Appends what holds to the set. @param space  number of the part that stands for space
  void append(std::span<const WorldPart> parts, std::span<const double> q, std::span<const std::size_t> first_q,
              int space, double time, double dt, ContactSet& set);
  /// Tells the response, after its begin. @param velocity_a, velocity_b  [m/s] at all contacts
  void begin(const ContactSet& set, std::span<const Vec3> velocity_a, std::span<const Vec3> velocity_b,
             Penalty& response) const;
  /// Takes the forces in and breaks what they break. @param force  [N] on side a, all contacts
  void finish(const ContactSet& set, std::span<const Vec3> force, double time, StepReport& report);

  /// Takes what memory holds of it, and removes it there; puts it before all else. Only what is broken is kept:
  ///   memory: [−0.125, n, numbers of broken links ...]
  void take(std::vector<double>& memory);
  void keep(std::vector<double>& memory) const;

 private:
  /// How a point is held, or what acts along the coordinate of a joint.
  enum class Hold { Point, Along, Across, Drive, Lower, Upper };
  struct Held {
    std::size_t point = 0;
    Hold hold = Hold::Point;
    double share = 1.0;       ///< of the link's stiffness
    double length = 0.0;      ///< [m] at rest, along a line
    Vec3 gap = Vec3::Zero();  ///< [m] of a against b as they were attached, which closes
  };
  struct Link {
    Attachment given;
    int body_a = -1, body_b = -1;
    std::int32_t part_a = 0, part_b = -1;  ///< −1: space
    MatterPoints a, b;
    std::vector<Held> held;
    Vec3 middle = Vec3::Zero();  ///< [m] of side b as it was attached
    double start = 0.0;          ///< [s] when that was
    double zero = 0.0;           ///< [rad or m] what its points say of a joint's coordinate as they were attached
    double mass = 0.0;           ///< [kg] that a rigid one is made for
    bool broken = false;
    void follow(std::span<const WorldPart> parts, std::span<const double> q, std::span<const std::size_t> first_q);
  };
  /// Where the coordinate of a joint is.
  struct Coordinate {
    Vec3 axis = Vec3::UnitZ();
    double value = 0.0;         ///< [rad or m]
    Vec3 n = Vec3::UnitZ();     ///< way of the point that acts, per length
    double lever = 1.0;         ///< [m] of the point that acts about the axis; 1 where it slides
    Vec3 point = Vec3::Zero();  ///< [m] that acts
  };
  /// A held point in a sub-step.
  struct Tie {
    std::size_t link = 0, held = 0;
    Vec3 error = Vec3::Zero();   ///< [m] of a against b; along n times the stretch
    Vec3 target = Vec3::Zero();  ///< [m/s] of a target that moves
    Vec3 n = Vec3::UnitZ();
    double lever = 1.0;
  };
  static Link make(const Attachment& attachment, std::span<const WorldPart> parts, const Side& a, const Side& b,
                   double ramp_voxels, double time);
  static void choose_held(Link& link, double h);
  static std::vector<Vec3> joint_points(const LinkJoint& joint, double span);
  static Coordinate coordinate(const Link& link);
  double rigid(const Link& link) const { return kRigid * link.mass / (dt_ * dt_); }
  /// Stiffness and damping along the coordinate, per length, and the force at the start.
  void drive(const Link& link, const Tie& tie, const Vec3& u, Bond& bond) const;

  std::vector<Link> links_;
  bool grabs_ = false;  ///< the last one
  std::vector<Tie> ties_;
  std::vector<Coordinate> coordinate_;  ///< per link
  double time_ = 0.0, dt_ = 0.0;
};

}  // namespace brim
