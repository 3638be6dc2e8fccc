#pragma once

#include <span>

#include "brim/math/types.h"

namespace brim {

/// What a body also is when it has walls of its own that no other body knows, such as the box of a grid.
class Walled {
 public:
  virtual ~Walled() = default;
  /// True when the walls keep the body from moving as a rigid whole: such motions are none of its own.
  virtual bool confined() const = 0;
  /// Told before finish_step: what contact, gravity and other forces gave in this sub-step to all of the body's
  /// coordinates, walls or not, [N s] (n_v). What acts where walls hold the body, they take.
  virtual void note_impulse(std::span<const double> impulse) = 0;
  /// Momentum that the body took from its walls in its last sub-step, and that left through openings, [N s].
  virtual Vec3 wall_impulse() const = 0;
};

}  // namespace brim
