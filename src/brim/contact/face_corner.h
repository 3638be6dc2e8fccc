#pragma once

#include <optional>

#include "brim/contact/cube_contacts.h"

namespace brim {

/// Sum of the distances to two solids over a flat face that they share: φ(y) = gap + slope·(y − x).
struct FacePlane {
  Vec3 x = Vec3::Zero(), n = Vec3::UnitZ();  ///< [m] a point of it; unit, perpendicular to it
  double gap = 0.0;                          ///< [m]
  Vec3 slope = Vec3::Zero();                 ///< [-] along the face
  double gap_at(const Vec3& y) const { return gap + slope.dot(y - x - n * n.dot(y - x)); }
};

/// Finds the corners of a flat face that two solids share, from the distances to both. Beyond an edge their sum rises
/// along a line, whose slope is that of the distance to the edge; sampled distances bend beside an edge, so the edge is
/// where this line meets the plane of the face:
///   r(y) = d_a(y) + d_b(y) − φ(y),   edge: y − r / |∇r| along the ray,   normal of the edge: ∇r along the face
/// Rays to both sides of a direction find the two edges that meet in the corner there.
/// Tests: tests/contact/face_corner_test.cpp
class FaceCorner {
 public:
  /// @param h  [m] grid step
  FaceCorner(const CubeSide& a, const CubeSide& b, double h, const FacePlane& face)
      : a_(a), b_(b), h_(h), face_(face) {}

  /// The corner that lies farthest in a direction, as seen from a point of the face; the rim there if it is round.
  /// @param from  [m] on the face, within some five voxels of the corner  @param out  along the face
  std::optional<Vec3> find(const Vec3& from, const Vec3& out) const;

 private:
  struct Edge {
    Vec3 x, normal;  ///< a point of it, and away from the face
  };
  /// The edge that a ray along the face meets. @param way  unit
  std::optional<Edge> edge_along(const Vec3& from, const Vec3& way) const;
  /// r at points from + t way, [m]. @param rise  size count
  void rises(const Vec3& from, const Vec3& way, const double* t, int count, double* rise) const;
  double rise(const Vec3& x) const;
  std::optional<Vec3> meeting(const Edge& one, const Edge& other) const;

  const CubeSide &a_, &b_;
  double h_;
  FacePlane face_;
};

}  // namespace brim
