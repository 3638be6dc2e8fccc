#pragma once

#include "brim/body/body.h"
#include "brim/world/touch_rules.h"

namespace brim {

/// A part as the world numbers it.
struct WorldPart {
  const Body* body = nullptr;
  int body_index = 0;
  int index = 0;   ///< within the body
  double h = 0.0;  ///< [m] its own grid step, h0 2^l
  PartInfo info;
  bool still = false;  ///< as Sleep marks it: asleep, or fixed and not moving; nothing is, where bodies do not sleep
  TouchRules::Sides sides{};          ///< of the body's name
  const TouchRules* rules = nullptr;  ///< nothing: all may touch
};

/// False for pairs that the scene or a link keeps from touching.
inline bool rules_allow(const WorldPart& a, const WorldPart& b) {
  return a.rules == nullptr || a.rules->touch(a.sides, a.body_index, b.sides, b.body_index);
}

/// False for pairs that are not looked at: nothing moves, or their body or the rules say that they do not touch.
inline bool may_touch(const WorldPart& a, const WorldPart& b) {
  if (a.body == b.body && !a.body->parts_collide(a.index, b.index)) return false;
  return !(a.still && b.still) && !(a.body->immobile() && b.body->immobile()) && rules_allow(a, b);
}

}  // namespace brim
