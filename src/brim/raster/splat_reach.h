#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "brim/mesh/tri_mesh.h"

namespace brim {

/// For each triangle of a surface, how far away nodes may lie whose nearest point is on it, up to a given reach. On a
/// smooth surface these nodes lie almost straight above and below the triangle: for small triangles at small angles, a
/// tenth of the volume that the reach alone gives.
///
/// Let all normals at a vertex v lie within an angle α < 90° of a direction n, let the triangles form a closed fan, and
/// all corners there be at most ψ. If v is the nearest point in the direction u, no edge e from v has e·u > 0, although
/// seen along n one of them is within ψ'/2 of u, tan(ψ'/2) = tan(ψ/2)/cos α. Hence
///   tan ∠(u, n) <= tan α / cos(ψ'/2),   ∠(u, normal of a triangle at v) <= ∠(u, n) + α = θ
/// and at an edge that angle is at most 2 α <= θ. So a node at distance d lies within d sin θ beside the triangle, with
/// the largest θ of its vertices. θ = 90° at open borders and in all other cases.
/// Tests: tests/raster/splat_reach_test.cpp
class SplatReach {
 public:
  /// @param reach  [m]  O(triangles)
  void build(std::span<const Vec3> x, std::span<const Triangle> triangles, double reach);
  /// Extension of the box of triangle t on either side, [m]; at most the reach.
  Vec3 beyond(std::size_t t) const { return beyond_[t].cast<double>(); }

 private:
  /// Geometry of the triangles around a vertex.
  struct Fan {
    Vec3f normal = Vec3f::Zero();  ///< sum of unit normals, then unit
    float along = 1.0f;            ///< smallest cosine between a normal and it
    float corner = 1.0f;           ///< smallest cosine of a corner
    std::uint64_t ring = 0;        ///< 0 when each edge has a triangle on both sides
  };
  std::vector<Fan> fan_;       // per vertex
  std::vector<float> aside_;   // per vertex: sin θ
  std::vector<Vec3f> normal_;  // per triangle; zero for zero area
  std::vector<Vec3f> corner_;  // per triangle: cosines of its corners
  std::vector<Vec3f> beyond_;  // per triangle, [m]
};

}  // namespace brim
