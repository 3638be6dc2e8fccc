#pragma once

#include <algorithm>

#include "brim/body/articulated/joint_stops.h"

namespace brim {

/// Target of a drive and its rate at a time, [s].
std::pair<double, double> target_at(const JointDrive& drive, double time);
/// Energy of a drive's spring that misses its target by so much, [J]; beyond the limit of its force that is constant.
double drive_energy(const JointDrive& drive, double miss);

/// Drives, limits, damping and dry friction of all joints, with derivatives for an implicit step.
///   drive     τ = s (kp (target − q) + kd (target' − q')),  s = min(1, force_limit / |τ at s = 1|)
///   limit     τ = −k (q − upper + T q') beyond upper, likewise below lower; τ = −k (q − upper) already when q + dt q'
///             is beyond; T = dt where k is given, else max(dt, 1/60 s): strains return no faster where steps are short
///   damping   τ = −d q'
///   friction  τ = −f q' / max(|q'|, ε),  ε = 0.01 f dt / m: a hundredth of the speed that friction stops in a step
/// m is the inertia felt by the joint. For a ball joint they act along its rotation vector from rest.
class JointForces {
 public:
  explicit JointForces(const ArticulatedModel& model);

  /// Reads the state. @param time  [s] for which drive targets are evaluated, the end of the step
  /// @param dt  [s] of the step ahead, 0 for none @param mass  from TreeInverse::pivot
  void update(const Tree& tree, double time, double dt, std::span<const double> q, std::span<const double> v,
              const TreeInverse& mass, const JointStops& stops);
  /// Stops that are hard and act in the step ahead, with their impulses if the solve ends at velocities v. @param T  of
  /// system(), per link: loses what is theirs
  std::vector<JointStop> stops(const Tree& tree, std::span<const double> v, std::span<Mat3> T) const;

  /// Lets go of the limits that would pull their joints outwards if the step ended at velocities v: a blow has taken
  /// them away. @return true when there are any
  bool release(const Tree& tree, std::span<const double> v);

  /// Q += forces.
  void add_forces(const Tree& tree, std::span<double> Q) const;
  /// y −= K x and y −= C x, K = −∂Q/∂q and C = −∂Q/∂v positive semi-definite.
  void subtract_stiffness(const Tree& tree, std::span<const double> x, std::span<double> y) const;
  void subtract_damping(const Tree& tree, std::span<const double> x, std::span<double> y) const;
  /// y += (dt C + dt² K) x.
  void add_system(const Tree& tree, double dt, std::span<const double> x, std::span<double> y) const;
  /// dt C + dt² K of one link's joint.
  Mat3 system(std::size_t link, double dt) const { return dt * term_[link].C + dt * dt * term_[link].K; }
  /// Energy of limits with a given stiffness and of drives within their force limit, [J].
  double energy() const { return energy_; }

  /// Range of a joint, [rad or m].
  std::pair<double, double> range(std::size_t link) const { return {joint_[link].lower, joint_[link].upper}; }
  /// What the drive of a revolute or prismatic joint applies at a time [s] and in a state, [N m or N].
  double drive_effort(std::size_t link, double time, double q, double v) const;
  /// Drive of a joint, by its link's number; may be changed between steps.
  JointDrive& drive(std::size_t link) { return joint_[link].drive; }
  const JointDrive& drive(std::size_t link) const { return joint_[link].drive; }
  /// True when some joint has an active drive.
  bool driven() const {
    return std::any_of(joint_.begin(), joint_.end(),
                       [](const Joint& j) { return j.drive.stiffness > 0.0 || j.drive.damping > 0.0; });
  }

 private:
  struct Joint {
    bool ball;
    double lower, upper, limit_stiffness, damping, friction;
    JointDrive drive;
  };
  struct Term {
    Vec3 force = Vec3::Zero();
    Mat3 K = Mat3::Zero(), C = Mat3::Zero();
  };
  /// @param x, u  displacement from rest and its rate, along the joint's velocities
  Term term(std::size_t link, double time, double dt, double mass, const Vec3& x, const Vec3& u, bool hard);
  void add_limits(std::size_t link, double dt, double mass, const Vec3& x, const Vec3& u, bool hard, Term& t);

  /// A limit that acts: its impulse is −push − resist u, its force at the start `force` inwards, of stiffness k and
  /// damping c.
  struct Acting {
    JointStop stop;
    double push, resist;
    double force, k, c;
    bool hard;
  };
  /// Impulse of a limit if the solve ends at velocities v, and its joint's rate outwards.
  static std::pair<double, double> impulse_of(const Acting& a, const Tree& tree, std::span<const double> v);

  std::vector<Joint> joint_;
  std::vector<Term> term_;
  std::vector<Acting> acting_;
  double energy_ = 0.0;
};

}  // namespace brim
