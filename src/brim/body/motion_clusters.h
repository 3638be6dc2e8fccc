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

/// True when the matter of two clusters may come closer than `reach` [m] along every axis in `time` [s].
inline bool may_meet(const MotionCluster& a, const MotionCluster& b, double reach, double time) {
  const double deviation = reach + (a.deviation + b.deviation) * time;
  const auto apart = [&](const MotionCluster& low, const MotionCluster& high) {
    const Vec3 closing = time * (low.velocity.hi - high.velocity.lo).cwiseMax(0.0);
    return ((high.box.lo - low.box.hi - closing).array() > deviation).any();
  };
  return !apart(a, b) && !apart(b, a);
}

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
  /// Appends smaller clusters that together hold the matter of one of those; none where there are none.
  /// @param cluster  its place among those of the part
  virtual void finer_clusters(int part, std::size_t cluster, std::span<const double> v,
                              std::vector<MotionCluster>& out) const = 0;
  /// True where matter of a part may meet other matter of it, as in a liquid: then that counts too.
  virtual bool meets_itself() const { return false; }
};

}  // namespace brim
