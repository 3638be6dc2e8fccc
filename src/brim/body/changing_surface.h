#pragma once

#include <vector>

#include "brim/body/body.h"

namespace brim {

/// A body whose display surface changes in every state: vertices and triangles appear and disappear, as those of a
/// fluid do. Its display() is of triangles without vertices; this interface gives the geometry instead.
class ChangingSurface {
 public:
  virtual ~ChangingSurface() = default;
  /// The surface in the last updated state, with vertices shared between neighbouring triangles.
  /// @param x          [m] vertices, world frame; overwritten
  /// @param triangles  counter-clockwise seen from outside; overwritten
  virtual void display_surface(std::vector<Vec3f>& x, std::vector<Triangle>& triangles) const = 0;
  /// False where the surface at x lies against the body's own wall, so that no air reaches it. @param x  [m]
  virtual bool meets_air(const Vec3& x) const {
    (void)x;
    return true;
  }
};

/// The body's changing surface, or null when its display has constant topology.
const ChangingSurface* changing_surface(const Body& body);

/// Display positions in the last updated state, for either kind of display, [m]; x is overwritten.
void display_now(const Body& body, std::vector<Vec3f>& x);

}  // namespace brim
