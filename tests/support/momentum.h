#pragma once

#include "brim/world/world.h"

namespace brim::testing {

struct Momentum {
  Vec3 linear = Vec3::Zero();   ///< [kg m/s]
  Vec3 angular = Vec3::Zero();  ///< [kg m²/s]
};

/// Of all bodies that can move.
inline Momentum momentum(const World& w) {
  Momentum p;
  for (int b = 0; b < w.body_count(); ++b) {
    if (w.body(b).immobile()) continue;
    p.linear += w.body(b).linear_momentum(w.v(b));
    p.angular += w.body(b).angular_momentum(w.v(b));
  }
  return p;
}

}  // namespace brim::testing
