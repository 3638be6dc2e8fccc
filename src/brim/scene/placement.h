#pragma once

#include <string>

#include "brim/math/types.h"

namespace brim {

/// Initial placement of one copy of a body: x = position + rotation · (scale x).
struct Placement {
  std::string name;
  Vec3 position = Vec3::Zero();  ///< [m]
  Quat rotation = Quat::Identity();
  Quat turned = Quat::Identity();        ///< part of the rotation by which copies in a circle turn with all they do
  double scale = 1.0;                    ///< [-]
  Vec3 velocity = Vec3::Zero();          ///< [m/s]
  Vec3 angular_velocity = Vec3::Zero();  ///< [rad/s], world frame

  Vec3 apply(const Vec3& x) const { return position + rotation * (scale * x); }
};

}  // namespace brim
