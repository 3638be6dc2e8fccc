#pragma once

#include <optional>

#include "brim/math/types.h"

namespace brim {

/// Motion that a user gives a body between steps: a constant velocity, or a pose at a time, with constant velocities on
/// the way and rest afterwards. Velocities are those of the origin of the body's frame.
struct KinematicMotion {
  bool to_pose = false;
  Vec3 velocity = Vec3::Zero();      ///< [m/s]
  Vec3 spin = Vec3::Zero();          ///< [rad/s]
  Vec3 position = Vec3::Zero();      ///< [m] of a target
  Quat rotation = Quat::Identity();  ///< of a target
  double at = 0.0;                   ///< [s] when the target is reached
};

/// Optional interface of bodies whose motion is prescribed and may be given step by step: obstacles. The world keeps
/// the motions in its state (World::set_velocity, World::set_target, KinematicMotions). Tests:
/// tests/world/kinematic_motions_test.cpp
class Kinematic {
 public:
  virtual ~Kinematic() = default;
  /// Sets the motion, which then holds; nothing: as the body was described, keyframes included. For a prescribe that
  /// follows.
  virtual void set_motion(const std::optional<KinematicMotion>& motion) = 0;
};

}  // namespace brim
