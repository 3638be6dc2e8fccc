#pragma once

#include <span>
#include <vector>

#include "brim/math/types.h"

namespace brim {

/// Some matter of a part, and bounds of its place and velocity: the velocity of any of it lies in the box `velocity`,
/// widened by a ball.
struct MotionCluster {
  Aabb box;                ///< [m] holds the matter, without ramp
  Aabb velocity;           ///< [m/s]
  double deviation = 0.0;  ///< [m/s] radius of the ball
};

/// Largest speed that some matter of two clusters may have relative to each other, [m/s].
inline double relative_speed(const MotionCluster& a, const MotionCluster& b) {
  const Vec3 most = (a.velocity.hi - b.velocity.lo).cwiseMax(b.velocity.hi - a.velocity.lo);
  return most.norm() + a.deviation + b.deviation;
}

/// Optional interface of bodies whose parts move differently from place to place: what one corner does then shortens
/// sub-steps only where that corner may touch something. Bodies without it count as one cluster a part.
class MotionClusters {
 public:
  virtual ~MotionClusters() = default;
  /// Appends clusters that together hold all matter of the part in the last updated state; none where the part is best
  /// taken whole. @param v  of the body
  virtual void motion_clusters(int part, std::span<const double> v, std::vector<MotionCluster>& out) const = 0;
};

}  // namespace brim
