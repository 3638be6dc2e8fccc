#pragma once

#include "brim/math/types.h"

namespace brim {

/// Position and motion of a body, the same for every kind.
struct BodySample {
  Vec3 center = Vec3::Zero();          ///< [m] mean of the display's vertices
  Vec3 velocity = Vec3::Zero();        ///< [m/s] of the centre of mass; zero for bodies of infinite mass
  Vec3 force = Vec3::Zero();           ///< [N] sum of contact forces on the body in the last sub-step
  Vec3 impulse = Vec3::Zero();         ///< [N s] of the contacts on the body over the frame
  double lowest = 0.0, highest = 0.0;  ///< [m] least and largest z of the display's vertices
  double tilt_degrees = 0.0;  ///< between the body's vertical at the start and the vertical now; the rotation is the
                              ///< best fit of all vertices (Kabsch 1976)
};

}  // namespace brim
