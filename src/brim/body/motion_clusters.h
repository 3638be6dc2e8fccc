#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "brim/math/types.h"

namespace brim {

/// Bounds of position and velocity of some matter of a part: all its velocities lie in the box `velocity`, expanded by
/// a ball.
struct MotionCluster {
  Aabb box;                ///< [m] contains the matter, without ramp
  Aabb velocity;           ///< [m/s]
  double deviation = 0.0;  ///< [m/s] radius of the ball
};

/// True when the matter of two clusters may come within `reach` [m] along every axis in `time` [s].
inline bool may_meet(const MotionCluster& a, const MotionCluster& b, double reach, double time) {
  const double deviation = reach + (a.deviation + b.deviation) * time;
  const auto apart = [&](const MotionCluster& low, const MotionCluster& high) {
    const Vec3 closing = time * (low.velocity.hi - high.velocity.lo).cwiseMax(0.0);
    return ((high.box.lo - low.box.hi - closing).array() > deviation).any();
  };
  return !apart(a, b) && !apart(b, a);
}

/// Upper bound of the relative speed of the matter of two clusters, [m/s].
inline double relative_speed(const MotionCluster& a, const MotionCluster& b) {
  const Vec3 most = (a.velocity.hi - b.velocity.lo).cwiseMax(b.velocity.hi - a.velocity.lo);
  return most.norm() + a.deviation + b.deviation;
}

/// The same of the speed along a unit vector n: the normal of a half-space to which one of the two belongs.
inline double relative_speed(const MotionCluster& a, const MotionCluster& b, const Vec3& n) {
  const Vec3 lo = a.velocity.lo - b.velocity.hi, hi = a.velocity.hi - b.velocity.lo;
  const double middle = 0.5 * n.dot(hi + lo), half = 0.5 * n.cwiseAbs().dot(hi - lo);
  return std::abs(middle) + half + a.deviation + b.deviation;
}

/// Optional interface of bodies whose parts move non-uniformly: fast motion of one corner then shortens sub-steps only
/// where that corner may touch something. Other bodies count as one cluster per part.
class MotionClusters {
 public:
  virtual ~MotionClusters() = default;
  /// Appends clusters that together contain all matter of the part in the last updated state; none when the part is
  /// best treated as a whole. @param v  of the body
  virtual void motion_clusters(int part, std::span<const double> v, std::vector<MotionCluster>& out) const = 0;
  /// Appends smaller clusters that together contain the matter of one cluster; none if there are none.
  /// @param cluster  its index among those of the part
  virtual void finer_clusters(int part, std::size_t cluster, std::span<const double> v,
                              std::vector<MotionCluster>& out) const = 0;
  /// True when matter of a part may meet other matter of it, as in a liquid: relative motion within it counts too.
  virtual bool meets_itself() const { return false; }
};

}  // namespace brim
