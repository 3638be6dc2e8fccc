#pragma once

#include <span>

#include "brim/math/types.h"

namespace brim {

/// Optional interface of bodies with walls of their own that no other body sees, such as the box of a grid.
class Walled {
 public:
  virtual ~Walled() = default;
  /// True when the walls keep the body from moving as a rigid whole: rigid motions are then not available.
  virtual bool confined() const = 0;
  /// Called before finish_step with the impulse of contact, gravity and other forces in this sub-step on all of the
  /// body's coordinates, walls or not, [N s] (n_v). Walls take the part on coordinates that they hold.
  virtual void note_impulse(std::span<const double> impulse) = 0;
  /// Momentum that the body received from its walls in its last sub-step, and that left through openings, [N s].
  virtual Vec3 wall_impulse() const = 0;
};

}  // namespace brim
