#pragma once

#include <array>
#include <limits>
#include <optional>

#include "brim/math/types.h"

namespace brim {

/// Half-line from a point, up to a distance.
struct Ray {
  Vec3 origin = Vec3::Zero();                               ///< [m]
  Vec3 direction = Vec3::UnitX();                           ///< unit
  double length = std::numeric_limits<double>::infinity();  ///< [m]
  Vec3 at(double t) const { return origin + t * direction; }
};

/// Point at which a ray enters something.
struct RayEntry {
  double distance = 0.0;        ///< [m] from the ray's origin
  Vec3 normal = Vec3::UnitZ();  ///< of the surface, against the ray
};

/// Nearest point of a surface, as seen from a point.
struct NearPoint {
  double distance = std::numeric_limits<double>::infinity();  ///< [m] signed, negative inside
  Vec3 point = Vec3::Zero();                                  ///< [m] on the surface
  Vec3 normal = Vec3::UnitZ();                                ///< of the surface, outward
};

/// Range of distances at which a ray is in a box. @return false when it misses the box
bool clip(const Ray& ray, const Aabb& box, double& begin, double& end);

/// Matter within `radius` of a corner, a segment or a triangle: a ball, a capsule or a slab with round edges.
struct RoundedSimplex {
  std::array<Vec3, 3> corner;  ///< [m]
  int corners = 1;             ///< 1 to 3
  double radius = 0.0;         ///< [m] >= 0

  Aabb bounds() const;
  /// A corner that is farthest along a direction, without the radius, [m].
  Vec3 support(const Vec3& direction) const;
};

/// First point of a ray on a simplex; the origin is outside. Triangles without radius are met from either side, and a
/// ray cannot slip between two with a common edge (Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", 2013).
/// Tests: tests/mesh/ray_test.cpp
std::optional<RayEntry> enter(const Ray& ray, const RoundedSimplex& simplex);

/// Nearest point of the simplex's surface. Without a radius the distance is not negative.
NearPoint nearest(const Vec3& p, const RoundedSimplex& simplex);

}  // namespace brim
