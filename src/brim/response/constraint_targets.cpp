// Targets of velocity and position for the rows of Constraint.
#include <algorithm>
#include <cmath>
#include <limits>

#include "brim/response/constraint.h"

namespace brim {

namespace {

/// [voxels] Points whose gap exceeds the smallest of their pair by more touch later, and do not bounce yet.
constexpr double kTogether = 0.02;
/// [voxels] overlap that is tolerated; share of the rest that is removed per step, and the most per step.
constexpr double kSlop = 0.005, kShare = 0.2, kPush = 0.1;
/// [voxels] gap that counts as contact: bodies do not rock on such small gaps.
constexpr double kTouch = 0.005;
/// [voxels] the same two for rigid parts with gaps read at nodes. These vary by a tenth from place to place: with
/// smaller values piles of meshes never come to rest.
constexpr double kSlopOffNodes = 0.1, kTouchOffNodes = 0.05;
/// [voxels] A flat landing bounces without rotation although its gaps are read at nodes: points within this touch
/// together.
constexpr double kTogetherOffNodes = 0.1;

}  // namespace

void Constraint::set_targets(const ConstraintOptions& options, std::span<const Vec3> start, std::span<const Vec3> free,
                             std::span<const double> lift) {
  const double dt = options.dt;
  velocity_target_.resize(points_.size()), position_target_.resize(points_.size());
  touch_time_.assign(points_.size(), 0.0);
  targets_differ_ = bounces_ = breaks_ = false;
  for (std::size_t p = 0; p < points_.pairs.size(); ++p) {
    const ContactPair& pair = points_.pairs[p];
    const double slop = off_nodes_[p] != 0 ? kSlopOffNodes : kSlop,
                 touch = off_nodes_[p] != 0 ? kTouchOffNodes : kTouch,
                 together = off_nodes_[p] != 0 ? kTogetherOffNodes : kTogether;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t c = pair.begin; c < pair.end; ++c) least = std::min(least, -double{points_.depth[c]});
    for (std::size_t c = pair.begin; c < pair.end; ++c) {
      const double gap = -points_.depth[c], open = std::max(0.0, gap);
      const double u0 = normal_[c].dot(start[c]), u1 = normal_[c].dot(free[c]), a = (u1 - u0) / dt;
      const double push = std::min(kShare * std::max(0.0, -gap - slop * pair.h), kPush * pair.h) / dt;
      // Round surfaces that do not part again meet at a moment of the step too, with the normal of that moment.
      const bool hits = restitution_[c] > 0.0 || (round_[c].any() && -u0 > options.bounce_speed);
      // A point that will bounce is not slowed down by the margin in the step before contact.
      const bool flies = hits && -u1 > options.bounce_speed;
      const double closing = -std::max(0.0, gap - (flies ? 0.0 : touch * pair.h)) / dt;
      velocity_target_[c] = closing + (lift.empty() ? 0.0 : lift[c]);
      position_target_[c] = closing + push;
      const bool touches = open + dt * u1 < 0.0;
      if (touches && hits && gap <= least + together * pair.h) {
        // The parabola of free flight (FreeFlight): open + u0 t + a t²/2 = 0.
        const double speed = std::sqrt(std::max(0.0, u0 * u0 - 2.0 * a * open));
        const double before = open > 0.0 && speed > u0 ? std::min(dt, 2.0 * open / (speed - u0)) : 0.0;
        const double hit = u0 + a * before, left = dt - before;
        if (-hit > options.bounce_speed) {
          touch_time_[c] = before;
          breaks_ = true;
          bounces_ = bounces_ || restitution_[c] > 0.0;
          const double after = -restitution_[c] * hit;
          velocity_target_[c] = std::max(0.0, after + a * left);
          position_target_[c] = std::max(push, (after * left + 0.5 * a * left * left) / dt) - open / dt;
        }
      }
      targets_differ_ = targets_differ_ || velocity_target_[c] != position_target_[c];
    }
  }
}

void Constraint::set_rebound(std::size_t c, double hit, double velocity, double dt) {
  velocity_target_[c] = std::max(0.0, velocity);
  const double open = std::max(0.0, -double{points_.depth[c]});
  if (touch_time_[c] == 0.0 && hit < 0.0) touch_time_[c] = std::min(dt, -open / hit);
  position_target_[c] = std::max(0.0, velocity) * (1.0 - touch_time_[c] / dt) - open / dt;
  targets_differ_ = targets_differ_ || velocity_target_[c] != position_target_[c];
}

}  // namespace brim
