#pragma once

#include <vector>

#include "brim/body/body.h"

namespace brim {

/// A body that shows another surface in every state: its vertices and triangles come and go, as those of a fluid do.
/// Its display() is of triangles and has no vertices; what is shown comes from here instead.
class ChangingSurface {
 public:
  virtual ~ChangingSurface() = default;
  /// The surface in the last updated state, with vertices shared between neighbouring triangles.
  /// @param x          [m] vertices, world frame; overwritten
  /// @param triangles  counter-clockwise seen from outside; overwritten
  virtual void display_surface(std::vector<Vec3f>& x, std::vector<Triangle>& triangles) const = 0;
  /// False where the surface at x lies against a wall of the body's own, so that no air reaches it. @param x  [m]
  virtual bool meets_air(const Vec3& x) const {
    (void)x;
    return true;
  }
};

/// The body's changing surface, or nothing where its display keeps its vertices.
const ChangingSurface* changing_surface(const Body& body);

/// Positions of what a body shows in the last updated state, whichever way it shows itself, [m]; x is overwritten.
void display_now(const Body& body, std::vector<Vec3f>& x);

}  // namespace brim
