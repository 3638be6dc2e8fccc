#pragma once

#include "brim/body/articulated/tree_inverse.h"
#include "brim/math/rotation.h"

namespace brim {

/// One side of a joint's range, for a joint that is on its way there or beyond.
struct JointStop {
  std::size_t link = 0;
  Vec3 outwards = Vec3::Zero();  ///< unit vector along the joint's velocities
  double most = 0.0;             ///< [rad/s or m/s] outwards that the stop leaves, >= 0 unless it pulls
  double impulse = 0.0;          ///< [N m s or N s] along outwards that acts already; negative: it stops
  /// The acting impulse is outwards, as of a spring that was taken to be met. Of it only so much stays as keeps the
  /// joint from moving outwards slower than `most`, which is <= 0.
  bool pulls = false;
};

/// Stops of a tree's joints without spring: each takes the motion outwards and never gives any. Energy cannot grow by
/// them, as every impulse is against the velocity that is left: with Δ = M⁻¹ Σ nᵢ Λᵢ and uᵢ = nᵢ (v + Δ),
///   E(v + Δ) − E(v) = Σ Λᵢ uᵢ − Δᵀ M Δ / 2 <= 0,  Λᵢ uᵢ <= 0.
/// Tests: tests/body/joint_stops_test.cpp
class JointStops {
 public:
  /// Ranges of the joints. No stop is hard before choose().
  explicit JointStops(const ArticulatedModel& model);

  /// True when no joint has a limit.
  bool empty() const { return limited_.empty(); }
  /// Decides which joints stop without spring over a step: those whose stiffness is not given, and those whose spring
  /// the step cannot resolve, k dt² >= m, which rebound no more in an implicit step either.
  void choose(double dt, const TreeInverse& mass);
  bool hard(std::size_t link) const { return hard_[link] != 0; }

  /// Stops that straight joint coordinates would come to or move on beyond within a time. @param dt  [s], > 0
  std::vector<JointStop> ahead(const Tree& tree, double dt, std::span<const double> q, std::span<const double> v) const;
  /// How far limited joints are beyond the nearer end of their range, [rad or m], negative within. Shape: (limited
  /// joints)
  std::vector<double> excess(const Tree& tree, std::span<const double> q) const;
  /// Replaces the impulses of stops by those of stops without spring: v is changed by A⁻¹ Σ n (Λ − impulse), A = M + T,
  /// momentum of a floating tree is not. @param T  what else answers in the joints, per link @param inverse  of A
  /// @return Σ Λ (u before + u after) / 2 < 0 with its sign changed, [J]: if T is zero, the energy that the stops take
  double hold(const Tree& tree, const TreePose& pose, const TreeInverse& inverse, std::span<const Mat3> T,
              std::span<const JointStop> stops, std::span<double> v);

 private:
  struct Limits {
    std::size_t link;
    double lower, upper, stiffness;
  };
  /// Velocities along the stops.
  void rates(const Tree& tree, std::span<const JointStop> stops, std::span<const double> v,
             std::span<double> rate) const;
  /// v += A⁻¹ Σ n Λ
  void push(const Tree& tree, const TreeInverse& inverse, std::span<const JointStop> stops,
            std::span<const double> impulse, std::span<double> v);

  /// Inverse of A with the stops that hold, as if heavy.
  bool factor_held(const Tree& tree, const TreePose& pose, std::span<const Mat3> T, std::span<const JointStop> stops);
  /// Impulses that leave the stops that hold their most, from rates at v; trial_rate_ is what all then have.
  void find_impulses(const Tree& tree, std::span<const JointStop> stops, std::span<const double> rate,
                     std::span<const double> v, std::span<double> impulse);

  std::vector<Limits> limited_;
  std::vector<std::uint8_t> hard_;  ///< one per link
  TreeInverse held_;
  std::vector<Mat3> terms_;
  std::vector<Vec6> scratch_;
  std::vector<double> load_, change_, trial_rate_, weight_;
  std::vector<std::uint8_t> holds_;
};

/// Displacement of a joint from rest along its velocities: the coordinate, or a ball joint's rotation vector.
inline Vec3 joint_displacement(int dof, const double* q) {
  if (dof == 1) return {q[0], 0, 0};
  return vector_from_rotation(Quat(q[0], q[1], q[2], q[3]).normalized());
}

}  // namespace brim
