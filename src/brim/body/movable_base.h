#pragma once

#include "brim/raster/shape.h"

namespace brim {

/// Optional interface of bodies that stand on a base which is no coordinate of theirs: a tree that is fixed to the
/// world, the box of a grid. The world keeps where the base is as a part of its state (World::move, Edits). Tests:
/// tests/world/moving_test.cpp
class MovableBase {
 public:
  virtual ~MovableBase() = default;
  /// Why the base cannot be turned by R, in words that follow the body's name; empty: it can.
  virtual const char* refuses_turn(const Mat3& R) const = 0;
  /// Sets all that was at x at the start to R x + t, whatever was said before. An update must follow.
  virtual void set_base(const Pose& from_start) = 0;
};

}  // namespace brim
