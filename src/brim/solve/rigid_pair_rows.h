#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "brim/math/types.h"

namespace brim {

/// Contact rows between pairs of rigid bodies, in compact form for sweeps. A pair interacts through six numbers, the
/// relative twist (V, Ω) of the bodies at a point x0 of the pair,
///   V = o'_a + ω_a × (x0 − c_a) − o'_b − ω_b × (x0 − c_b),   Ω = ω_a − ω_b
/// so all contacts of a pair are relaxed on the twist before the bodies' velocities are updated:
///   u_i = F_i V + G_i Ω,  rows of G: d × n, e × t1, e × t2       velocity at contact i in its frame, rows n, t1, t2
///   Δ(V, Ω) = B (F_iᵀ Δλ_i, G_iᵀ Δλ_i)        B: response of the twist to a force and a torque at x0
/// with lever arms d = x_i − x0 of the normal impulse and e = y_i − x0 of friction, which may act at another point. The
/// bodies get the sums of forces and torques, equal and opposite: linear and angular momentum are exact. Responses only
/// determine the size of a correction, not its target, and are stored in single precision: sweeps over thousands of
/// bodies are bound by memory.
/// Tests: tests/solve/rigid_pair_rows_test.cpp
class RigidPairRows {
 public:
  static constexpr std::size_t kFixed = std::numeric_limits<std::size_t>::max();
  /// A body of a pair: its velocities (o', ω) start at `first`; kFixed when nothing changes them.
  struct Side {
    std::size_t first = kFixed;
    Vec3 center = Vec3::Zero();           ///< [m] c
    double inverse_mass = 0.0;            ///< [1/kg]
    Mat3 inverse_inertia = Mat3::Zero();  ///< [1/(kg m²)] world axes
  };

  void clear();
  /// Adds a pair; shape (contacts). @param points [m]  @param grips [m] where friction acts, equal to the points if
  /// there  @param frames  rows n (towards a), t1, t2  @param friction  [-]
  void add(const Side& a, const Side& b, std::span<const Vec3> points, std::span<const Vec3> grips,
           std::span<const Mat3> frames, double friction);
  /// Moves where friction acts at contact i, with the impulse that acts there: v changes by its torque.
  /// @param way  [m]
  void move_friction(std::size_t i, const Vec3& way, const Vec3& impulse, std::span<double> v);
  std::size_t pairs() const { return pair_.size(); }
  std::size_t size() const { return row_.size(); }

  /// F V + G Ω at contact i, numbered over all pairs.
  Vec3 velocity(std::size_t i, std::span<const double> v) const;
  /// v += response to the impulse λ at contact i.
  void add_response(std::size_t i, const Vec3& impulse, std::span<double> v) const;
  /// Q += force and torque of the impulse on both bodies, for velocities below Q's size.
  void add_force(std::size_t i, const Vec3& impulse, std::span<double> Q) const;

  /// First velocity of each of the two bodies of a pair, or kFixed.
  std::pair<std::size_t, std::size_t> bodies(std::size_t pair) const {
    return {pair_[pair].a.first, pair_[pair].b.first};
  }
  /// Pair of contact i.
  std::size_t pair_of(std::size_t i) const { return row_[i].pair; }
  double friction(std::size_t i) const { return pair_[row_[i].pair].friction; }

  /// Relaxes the contacts of a pair in forward or backward order, `rounds` times.
  /// @param friction  multiplies that of the pair, 0 or 1  @param offset, target, impulse  of the pair's contacts
  /// @return largest change of any u in the first round, [m/s]
  double relax(std::size_t pair, bool backward, int rounds, double friction, std::span<const Vec3> offset,
               std::span<const double> target, std::span<Vec3> impulse, std::span<double> v) const;

 private:
  struct Pair {
    Side a, b;
    Vec3 arm_a, arm_b;  ///< [m] x0 − c
    double friction = 0.0;
    std::size_t begin = 0, end = 0;
  };
  struct Row {
    Mat3 frame, lever;                     ///< F; G, [m]
    Eigen::Matrix<float, 6, 3> twist;      ///< B (f, torque of f) for unit impulses f along the rows
    Eigen::Matrix3f local, local_inverse;  ///< W: response of u at this contact; its inverse or zero
    std::uint32_t pair = 0;
  };
  /// Responses of a row, from its frame and levers.
  static void set_responses(const Pair& p, Row& r);
  static void add_wrench(const Pair& p, const Vec3& force, const Vec3& torque, std::span<double> v);

  std::vector<Pair> pair_;
  std::vector<Row> row_;
};

}  // namespace brim
