#pragma once

#include <span>

#include "brim/math/types.h"

namespace brim {

/// Optional interface of bodies that know the velocities of their display's vertices: u = (∂x/∂q) v. Not needed by a
/// step; exports write them for motion blur. Tests: tests/record/export_velocities_test.cpp
class MovingDisplay {
 public:
  virtual ~MovingDisplay() = default;
  /// In the last updated state.
  /// @param v  generalised velocities of the body, shape (nv)
  /// @param x  [m] vertices of the display, as display_now() gives them
  /// @param u  [m/s], overwritten, shape (vertices)
  virtual void display_velocities(std::span<const double> v, std::span<const Vec3f> x, std::span<Vec3f> u) const = 0;
};

/// One vector for each node, of velocities that are those of nodes; shape (nv / 3).
inline std::span<const Vec3> node_vectors(std::span<const double> v) {
  return {reinterpret_cast<const Vec3*>(v.data()), v.size() / 3};
}

}  // namespace brim
