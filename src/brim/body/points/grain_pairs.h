#pragma once

#include <span>
#include <vector>

#include "brim/body/blocks_of_six.h"
#include "brim/body/points/neighbour_search.h"

namespace brim {

/// Contact parameters between grains.
struct GrainMaterial {
  double young = 1e6;     ///< E [Pa], > 0
  double friction = 0.5;  ///< Coulomb coefficient of grain on grain, [-], >= 0
  double rolling = 0.1;   ///< μ_r of rolling resistance, [-], >= 0
  double damping = 0.0;   ///< b [s], >= 0: normal force −b k (rate of overlap)
  double gravity =
      9.81;  ///< [m/s²] that may press free grains together, >= 0: pairs that separate more slowly are kept
  double slip_speed = 1e-3;  ///< ε [m/s], > 0: below it friction grows linearly, so a heap creeps at less than this
};

/// Forces between the balls of one body, linear and pairwise; n from b to a, d their distance, δ the overlap,
/// l_a = d r_a / (r_a + r_b) the lever of a, likewise for b; u is the velocity of a relative to b at the contact:
///   u = v_a − v_b − (l_a ω_a + l_b ω_b) × n
///   k = 2 E r_a r_b / (r_a + r_b)                 (linear springs in series, each 2 E r)
///   normal     f_n = k δ − b k n·u                E = Σ ½ k δ²
///   friction   −μ N u_t / max(|u_t|, ε),          N = max(0, k δ − b k n·u)
///   rolling    −μ_r R N w / max(|w|, ε/R) on a, the opposite on b; w = ω_a − ω_b, R = r_a r_b / (r_a + r_b)
///              (constant directional torque: Zhou, Wright, Yang, Xu and Yu, Physica A 269, 1999; R of Ai, Chen, Rotter
///              and Ooi, Powder Technology 206, 2011)
///   torque     −l_a n × f on a, −l_b n × f on b: with l_a + l_b = d angular momentum is exact
///   K = k n nᵀ,  D = b k n nᵀ + μ N / max(|u_t|, ε) (I − n nᵀ), both of u
/// The transverse part of K, −k δ/d, is negative and dropped. A pair that would touch within the step, δ − dt n·u > 0,
/// is included with its spring only, so that it stops at contact; so is one that a solve closes (foresee). A touching
/// pair is released when it separates so fast that it would not push at the end of the step even under gravity and a
/// load like its present one:
///   δ + (dt + b) (−n·u + dt (g + k δ (1/m_a + 1/m_b))) <= 0
/// Without these loads in the balance a grain lying on another would bounce for ever.
/// Velocities have six numbers per grain, v and ω; forces likewise, f and torque.
class GrainPairs {
 public:
  using Mat6 = Eigen::Matrix<double, 6, 6>;

  /// Finds the pairs near each other. @param gap  [m] largest gap of pairs that are evaluated later
  void find(std::span<const Vec3> x, std::span<const double> radius, double gap);
  double gap() const { return gap_; }
  /// Reads the state and computes forces, K and D. @param dt  [s] of the step to come; 0: touching pairs only, springs
  /// alone
  /// @param v, spin  [m/s], [rad/s] one per grain
  void evaluate(std::span<const Vec3> x, std::span<const Vec3> v, std::span<const Vec3> spin,
                std::span<const double> radius, std::span<const double> mass, const GrainMaterial& material, double dt);

  /// After evaluate: adds the pairs that these velocities would have overlap by a hundredth of the smaller
  /// radius at the end of the step; none is released.
  /// @param after, spin_after  [m/s], [rad/s] at the end of the step  @param others  as in evaluate
  /// @return true when there are such pairs
  bool foresee(std::span<const Vec3> after, std::span<const Vec3> spin_after, std::span<const Vec3> x,
               std::span<const Vec3> v, std::span<const Vec3> spin, std::span<const double> radius,
               std::span<const double> mass, const GrainMaterial& material, double dt);

  /// Adds the forces of the last evaluation on each grain, [N], and torques, [N m].
  void add_forces(std::span<Vec3> f, std::span<Vec3> torque) const;
  /// y += (a K + b D) x, shape (6 grains). Parallel over grains; same bits for any number of threads.
  void multiply_add(double a, double b, std::span<const double> x, std::span<double> y) const;
  /// The diagonal block of a grain in a K + b D.
  Mat6 diagonal(std::size_t grain, double a, double b) const;
  /// Stores the blocks of a K + b D between grains, for couplings().
  void couple(double a, double b);
  /// Those blocks, without prescribed velocities. Views: valid until the next call of couple.
  SixCouplings couplings() const { return {coupled_first_, coupled_, coupling_, {}}; }
  /// Energy of the springs of touching pairs, [J].
  double energy() const;
  /// Number of touching pairs.
  std::size_t touching() const;
  /// Largest overlap over the smaller radius, [-].
  double worst_overlap() const { return worst_overlap_; }

 private:
  struct Contact {
    Vec3 normal = Vec3::Zero();
    Vec3 force = Vec3::Zero();        // on a
    double arm_a = 0.0, arm_b = 0.0;  // [m] l
    double k = 0.0;                   // stiffness; 0: not in contact
    double damper = 0.0;              // along n
    double roll = 0.0;                // [N m s] of relative spin
    Vec3 roll_torque = Vec3::Zero();  // on a
    double drag = 0.0;                // tangential
    double energy = 0.0;
    Mat3 matrix(double a, double b) const;
    Vec3 times(double a, double b, const Vec3& d) const;
    /// X of grain a, or of the other: its velocity at the contact is v − X ω.
    Mat3 arm(bool of_a) const { return skew((of_a ? -arm_a : arm_b) * normal); }
  };
  struct Side {
    std::int32_t other, pair;
  };
  /// A pair without forces. @param overlap  set to δ, [m]
  static Contact meeting(const NeighbourSearch::Pair& p, std::span<const Vec3> x, std::span<const double> radius,
                         const GrainMaterial& material, double& overlap);
  /// u of a pair, [m/s].
  static Vec3 sliding(const Contact& c, const NeighbourSearch::Pair& p, std::span<const Vec3> v,
                      std::span<const Vec3> spin);
  /// Sets the forces of a pair that acts in a step.
  static void press(Contact& c, const NeighbourSearch::Pair& p, double overlap, const Vec3& u,
                    std::span<const Vec3> spin, std::span<const double> radius, const GrainMaterial& material);
  static Contact contact(const NeighbourSearch::Pair& p, std::span<const Vec3> x, std::span<const Vec3> v,
                         std::span<const Vec3> spin, std::span<const double> radius, std::span<const double> mass,
                         const GrainMaterial& material, double dt);
  std::span<const Side> sides_of(std::size_t grain) const {
    return std::span(side_).subspan(first_[grain], first_[grain + 1] - first_[grain]);
  }

  double gap_ = 0.0, worst_overlap_ = 0.0;
  NeighbourSearch search_;
  std::span<const NeighbourSearch::Pair> pair_;
  std::vector<Contact> contact_;    // per pair
  std::vector<std::size_t> first_;  // per grain
  std::vector<Side> side_;          // by grain: its pairs, in order
  std::vector<std::int32_t> coupled_first_, coupled_;
  std::vector<SixCouplings::Block> coupling_;
};

}  // namespace brim
