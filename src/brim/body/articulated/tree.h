#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "brim/body/articulated/tree_model.h"

namespace brim {

using Vec6 = Eigen::Matrix<double, 6, 1>;  ///< twist (velocity, angular velocity) or wrench (force, torque)
using Mat6 = Eigen::Matrix<double, 6, 6>;  ///< from twists to momenta, both at the same point

/// Calls f with the number of a joint's velocities as a compile-time constant; not at all for 0.
template <class F>
void with_dof(int dof, const F& f) {
  if (dof == 1) f(std::integral_constant<int, 1>{});
  if (dof == 3) f(std::integral_constant<int, 3>{});
  if (dof == 6) f(std::integral_constant<int, 6>{});
}

/// Poses of all links of a tree, a function of q. World axes throughout; twists and wrenches of a link are taken at the
/// link's own origin, so results do not depend on the world's origin.
struct TreePose {
  struct Link {
    Mat3 rotation;                  ///< from the link's frame
    Vec3 origin;                    ///< [m]
    Vec3 arm;                       ///< [m] from the parent's origin to this one
    Vec3 center;                    ///< [m] from the origin to the centre of mass
    Mat3 inertia;                   ///< [kg m²] about the centre of mass
    Eigen::Matrix<double, 6, 6> S;  ///< first columns: twist relative to the parent per joint velocity
  };
  std::vector<Link> link;
};

/// The constant part of a tree of links, and the recursions over it; each is linear in the number of links
/// (Featherstone, Rigid Body Dynamics Algorithms, 2008, here in world axes).
class Tree {
 public:
  struct Link {
    int parent = -1;
    JointKind kind = JointKind::Fixed;
    int dof = 0;
    int block = -1;  ///< number among the movable joints
    std::size_t q0 = 0, v0 = 0;
    Mat3 frame_rotation;  ///< of the joint in the parent
    Vec3 frame_position;
    Pose start_frame;  ///< the same before any set_base
    Vec3 axis;
    double mass = 0.0;
    Vec3 com;
    Mat3 inertia;
    double armature = 0.0;
  };

  /// @throws InputError for a parent that is not earlier, an axis of length zero, a negative mass or inertia, and a
  ///                    tree without movable joints
  explicit Tree(const ArticulatedModel& model);

  std::span<const Link> links() const { return links_; }
  std::size_t size() const { return links_.size(); }
  std::size_t q_size() const { return nq_; }
  std::size_t v_size() const { return nv_; }
  const std::vector<int>& block_sizes() const { return blocks_; }
  /// True when the whole tree is connected to the world by one free joint, so that its momentum is conserved.
  bool floating() const { return floating_; }
  /// True when some link is connected to the world by a free joint, so that its coordinates are in the world frame.
  bool has_free() const { return has_free_; }
  /// Moves the joint frames attached to the world from x at the start to R x + t. Only for trees without free joints.
  void set_base(const Pose& from_start);

  /// Poses of the links. Quaternions may have any length.
  void place(std::span<const double> q, TreePose& pose) const;
  /// q ← q ⊕ dt v: along straight coordinates, quaternions by the exponential map.
  void move(double dt, std::span<const double> v, std::span<double> q) const;
  /// Displacement between two configurations: to = from ⊕ way, way in the coordinates of v.
  void way(std::span<const double> from, std::span<const double> to, std::span<double> way) const;
  /// Rate q' of the coordinates, quaternions unnormalised, for Runge-Kutta stages.
  void rate(std::span<const double> q, std::span<const double> v, std::span<double> q_rate) const;

  /// Twist of every link, outwards: V_i = X V_parent + S_i v_i.
  void twists(const TreePose& pose, std::span<const double> v, std::span<Vec6> V) const;
  /// Q += Σ Jᵀ W, inwards. @param W  wrenches on the links; overwritten by those carried by each joint
  void add_wrenches(const TreePose& pose, std::span<Vec6> W, std::span<double> Q) const;
  /// y += M x, armature included. @param V  scratch, shape (links)
  void add_mass(const TreePose& pose, std::span<const double> x, std::span<Vec6> V, std::span<double> y) const;
  /// Accelerations of the links' origins and spins, outwards. @param V  twists of v  @param rate  of v, or empty: none
  void accelerations(const TreePose& pose, std::span<const double> v, std::span<const Vec6> V,
                     std::span<const double> rate, std::span<Vec6> a) const;
  /// C += forces that keep all joint velocities constant: recursive Newton-Euler without joint acceleration or weight.
  /// @param V  twists of v; overwritten. @param a scratch, shape (links)
  void add_bias(const TreePose& pose, std::span<const double> v, std::span<Vec6> V, std::span<Vec6> a,
                std::span<double> C) const;
  /// Total momentum about a point, [kg m/s, kg m²/s].
  Vec6 momentum(const TreePose& pose, std::span<const Vec6> V, const Vec3& point) const;
  double total_mass() const { return mass_; }
  /// [m] of all links.
  Vec3 mass_center(const TreePose& pose) const;
  /// J: velocity of a point of a link and the link's angular velocity, world frame, per joint velocity.
  /// @param arm  [m] from the link's origin to the point  @return shape (6, nv)
  Eigen::Matrix<double, 6, Eigen::Dynamic> jacobian(const TreePose& pose, int link, const Vec3& arm) const;

 private:
  std::vector<Link> links_;
  std::vector<int> blocks_;
  std::size_t nq_ = 0, nv_ = 0;
  double mass_ = 0.0;
  bool floating_ = false, has_free_ = false;
};

/// Inertia of a link at its origin.
Mat6 spatial_inertia(double mass, const Vec3& center, const Mat3& inertia);
/// A twist transferred to another point. @param arm  from the old to the new point
inline Vec6 moved_twist(const Vec6& V, const Vec3& arm) {
  Vec6 out = V;
  out.head<3>() += V.tail<3>().cross(arm);
  return out;
}
/// Inertia at a point of a body with inertia I at point + arm.
Mat6 moved_inertia(const Mat6& I, const Vec3& arm);

}  // namespace brim
