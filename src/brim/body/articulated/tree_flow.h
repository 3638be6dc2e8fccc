#pragma once

#include "brim/body/articulated/joint_stops.h"

namespace brim {

/// Force-free motion of a tree over a time: M(q) v' + C(q, v) = 0. Kinetic energy is an invariant, and so is the
/// momentum of a floating tree. Forces act before it, as impulses, so that one step of a pendulum is symplectic
/// (Lie-Trotter splitting) and velocity products of fast links never enter the linear solve.
///
/// Fourth-order Runge-Kutta, with as many pieces as needed to keep kinetic energy to kEnergyTolerance (at most 64);
/// then a floating tree's momentum is restored to rounding, and any growth of energy is removed.
/// Tests: tests/body/tree_flow_test.cpp
class TreeFlow {
 public:
  static constexpr double kEnergyTolerance = 1e-7;
  static constexpr int kMaxPieces = 64;

  /// @param q, v  moved in place @return the number of pieces
  int run(const Tree& tree, double dt, std::span<double> q, std::span<double> v) { return run(tree, dt, q, v, none_); }
  /// The same with joints that stop: what the stops take is the only loss of energy.
  int run(const Tree& tree, double dt, std::span<double> q, std::span<double> v, JointStops& stops);

  /// Displaces a tree without changing velocities. Joint velocities stay; a floating tree keeps its momentum and its
  /// spin about its centre of mass.
  /// @param way  in the coordinates of v  @param q, v  moved in place
  void shift(const Tree& tree, std::span<const double> way, std::span<double> q, std::span<double> v);
  /// Displaces a tree as shift does, but never with more kinetic energy than before: if its inertia grows on the way,
  /// the joints are slowed. A floating tree that cannot pay from its joints stays where it is.
  void carry(const Tree& tree, std::span<const double> way, std::span<double> q, std::span<double> v);

 private:
  void piece(const Tree& tree, double dt);
  /// Energy taken by the stops ahead of a piece.
  double stop(const Tree& tree, double dt, JointStops& stops);
  /// rate_ = −M⁻¹ C at (stage_q_, stage_v_)
  void acceleration(const Tree& tree);
  double kinetic_energy(const Tree& tree, std::span<const double> q, std::span<const double> v);
  /// [m] at the last placement
  Vec3 center_of_mass(const Tree& tree) const;
  void restore_momentum(const Tree& tree, const Vec6& wanted, const Vec3& point);

  TreePose pose_;
  TreeInverse inverse_;
  std::vector<double> q_, v_, stage_q_, stage_v_, rate_q_, rate_v_, sum_q_, sum_v_, bias_;
  std::vector<Vec6> twist_, scratch_;
  std::vector<Mat3> unloaded_;
  JointStops none_{ArticulatedModel()};
};

}  // namespace brim
