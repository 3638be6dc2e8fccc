#pragma once

#include "brim/body/body.h"

namespace brim {

/// A part as the world numbers it.
struct WorldPart {
  const Body* body = nullptr;
  int body_index = 0;
  int index = 0;   ///< within the body
  double h = 0.0;  ///< [m] its own grid step, h0 2^l
  PartInfo info;
  bool still = false;  ///< as Sleep marks it: asleep, or fixed and not moving; nothing is, where bodies do not sleep
};

/// False for pairs that are not looked at: nothing moves, or their body says that they do not touch.
inline bool may_touch(const WorldPart& a, const WorldPart& b) {
  if (a.body == b.body && !a.body->parts_collide(a.index, b.index)) return false;
  return !(a.still && b.still) && !(a.body->immobile() && b.body->immobile());
}

}  // namespace brim
