#pragma once

#include "brim/raster/shape.h"

namespace brim {

/// Optional interface of bodies on a base that is not part of their coordinates: a tree fixed to the world, the box of
/// a grid. The world stores the pose of the base in its state (World::move, Edits). Tests:
/// tests/world/moving_test.cpp
class MovableBase {
 public:
  virtual ~MovableBase() = default;
  /// Reason why the base cannot be rotated by R, as words that follow the body's name; empty: it can.
  virtual const char* refuses_turn(const Mat3& R) const = 0;
  /// Moves everything from x at the start to R x + t, replacing earlier calls. An update must follow.
  virtual void set_base(const Pose& from_start) = 0;
};

}  // namespace brim
