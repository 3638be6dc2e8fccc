#pragma once

#include <span>

#include "brim/raster/shape.h"

namespace brim {

/// Optional interface of bodies that can be moved as a whole between steps (World::move). Kinds whose place is fixed,
/// such as the box of a grid, do not have it.
/// Tests: tests/world/moving_test.cpp
class Movable {
 public:
  virtual ~Movable() = default;
  /// Transforms q and v to the same matter at R x + t, with velocities R u.
  /// @param by  R a rotation  @param q, v  of the body, changed in place
  virtual void move(const Pose& by, std::span<double> q, std::span<double> v) const = 0;
  /// Reason why the body cannot be moved, as words that follow its name: "is fixed to the world by its base"; empty: it
  /// can.
  virtual const char* bound() const { return ""; }
  /// True when keyframes prescribe its position, or part of it: moved or frozen, it would jump back.
  virtual bool driven() const { return false; }

 protected:
  /// x_i ← R x_i + t, u_i ← R u_i. @param x, u  shape (3 n)
  static void move_points(const Pose& by, std::span<double> x, std::span<double> u);
  /// The same for a frame. @param q  origin and quaternion w x y z  @param v  of the origin, and spin; world axes
  static void move_frame(const Pose& by, std::span<double> q, std::span<double> v);
};

}  // namespace brim
