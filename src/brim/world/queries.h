#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "brim/body/body.h"
#include "brim/mesh/ray.h"
#include "brim/raster/shape.h"

namespace brim {

/// Answer of World::raycast and World::closest_point.
struct QueryHit {
  int body = -1;
  int part = 0;                 ///< within the body, as PartRef::index
  Vec3 point = Vec3::Zero();    ///< [m] on the surface
  Vec3 normal = Vec3::UnitZ();  ///< of the surface, outward
  double distance = 0.0;        ///< [m] along the ray; from the point to the surface, negative inside
};

/// The matter of a body that is not made of solids, as it is shown, at its last update:
///   grains, particles of a fluid   balls of their radius
///   rods, nets of springs          segments of their radius
///   sheets                         triangles of half their thickness
///   all others                     the inside of the closed surface of triangles
/// Made anew for each query. Cost: linear in the vertices and triangles.
/// Tests: tests/world/queries_test.cpp
class ShownMatter {
 public:
  explicit ShownMatter(const Body& body);

  std::size_t size() const { return count_; }
  RoundedSimplex simplex(std::size_t i) const;
  /// True when the matter is what a surface encloses.
  bool filled() const { return filled_; }
  /// Whether a point lies within the closed surface: its winding number is above 1/2.
  bool encloses(const Vec3& p) const;

  /// First point of a ray on the matter; one that begins inside meets it at distance 0, with the normal against the
  /// ray.
  std::optional<RayEntry> enter(const Ray& ray) const;
  /// Nearest point of the surface; an infinite distance when there is no matter.
  NearPoint nearest(const Vec3& p) const;
  /// True when there is matter in a box. @param box  of its centre  @param half  [m] half of its extents
  bool meets_box(const Pose& box, const Vec3& half) const;

 private:
  Vec3 at(std::int32_t i) const { return x_[static_cast<std::size_t>(i)]; }

  std::vector<Vec3> x_;         // [m]
  std::vector<double> radius_;  // [m] of each corner where they differ
  std::vector<Triangle> own_;   // of a changing surface
  std::span<const Triangle> triangles_;
  std::span<const std::array<std::int32_t, 2>> lines_;
  Aabb box_;  // of the vertices
  std::size_t count_ = 0;
  double same_radius_ = 0.0;  // [m]
  bool filled_ = false;
};

}  // namespace brim
