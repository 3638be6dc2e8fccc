#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "brim/contact/contact_set.h"
#include "brim/math/types.h"

namespace brim {

/// A contact point held by a row.
struct RowPoint {
  Vec3 point = Vec3::Zero();   ///< [m]
  Vec3 normal = Vec3::Zero();  ///< unit, towards a
  double gap = 0.0;            ///< [m]
  Vec3 grip = Vec3::Zero();    ///< [m] from the point to where friction acts, tangential (friction_radius.h)
  /// [1/m] curvature of each surface there, positive when convex, as uu, uv, vv in tangents_of(normal)
  std::array<float, 3> bend_a{}, bend_b{};
};

/// Motion of a rigid solid between two poses: x → x + turn (x − center) + shift, turn = R − 1.
struct RigidMotion {
  bool none = true;              ///< true: no motion at all
  Mat3 turn = Mat3::Zero();      ///< [-]
  Vec3 center = Vec3::Zero();    ///< [m] before
  Vec3 shift = Vec3::Zero();     ///< [m] of the centre
  Vec3 rotation = Vec3::Zero();  ///< [rad] R as a vector, for small turns

  Vec3 displacement(const Vec3& x) const { return none ? Vec3(Vec3::Zero()) : Vec3(turn * (x - center) + shift); }
};

/// A row after displacements δ and rotations θ of the two bodies by a fraction of a voxel each. The gap follows the
/// relative displacement along the normal, φ + n·(δ_a − δ_b). On curved surfaces the point of smallest gap does not
/// move with the material but rolls (C: curvatures; x tangential):
///   (C_a + C_b) x = C_a δ_a + C_b δ_b + (θ_a − θ_b) × n
/// On flat ones it moves with the mean of both. The normal is that of the flatter surface at the new point.
/// Second-order terms, curvature times the square of the tangential displacement, are neglected.
/// @param h  [m] grid step  @param farthest  [h] that the point rolls
RowPoint moved(const RowPoint& row, const RigidMotion& a, const RigidMotion& b, double h, double farthest = 0.2);

/// Two unit vectors perpendicular to a unit normal, as the columns of a matrix.
Eigen::Matrix<double, 3, 2> tangents_of(const Vec3& n);

/// A curvature of RowPoint as a tensor, [1/m].
Mat3 bend_across(const std::array<float, 3>& packed, const Vec3& n);

/// Rows of a pair whose contacts are not stored in the contact set.
struct PairRows {
  std::int32_t part_a = 0, part_b = 0;  ///< global part numbers, part_a < part_b
  double h = 0.0;                       ///< [m] step at which they meet
  double w = 0.0;                       ///< [m] ramp width at that step
  double friction = 0.0, restitution = 0.0;
  bool off_nodes = false;          ///< gaps read at grid nodes, not from formulas
  std::size_t begin = 0, end = 0;  ///< rows of the pair
};

/// Rows gathered already, of pairs ordered by part numbers.
struct GatheredRows {
  std::span<const PairRows> pairs;
  std::span<const RowPoint> rows;
};

}  // namespace brim
