#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "brim/mesh/tri_mesh.h"

namespace brim {

/// How far around each triangle of a surface nodes may lie that have their nearest point on it, no farther than some
/// reach. On a smooth surface these are little more than what lies straight above and below the triangle: where small
/// triangles meet at small angles, a tenth of what the reach alone would allow.
///
/// Let all normals at a vertex v lie within an angle α < 90° of one direction n, the triangles form a closed fan, and
/// no corner there exceed ψ. Where v is the nearest point, in the direction u, no edge e from v has e·u > 0, although
/// seen along n one of them is within ψ'/2 of u, tan(ψ'/2) = tan(ψ/2)/cos α. Hence
///   tan ∠(u, n) <= tan α / cos(ψ'/2),   ∠(u, normal of a triangle at v) <= ∠(u, n) + α = θ
/// and at an edge that angle is at most 2 α <= θ. So a node at distance d lies within d sin θ beside the triangle, with
/// the largest θ of its vertices. Open borders and anything else have θ = 90°.
/// Tests: tests/raster/splat_reach_test.cpp
class SplatReach {
 public:
  /// @param reach  [m]  O(triangles)
  void build(std::span<const Vec3> x, std::span<const Triangle> triangles, double reach);
  /// What to add on either side of the box of triangle t, [m]; at most the reach.
  Vec3 beyond(std::size_t t) const { return beyond_[t].cast<double>(); }

 private:
  /// What the triangles around a vertex say of it.
  struct Fan {
    Vec3f normal = Vec3f::Zero();  ///< sum of unit normals, then unit
    float along = 1.0f;            ///< least cosine of a normal against it
    float corner = 1.0f;           ///< least cosine of a corner
    std::uint64_t ring = 0;        ///< 0 where each edge has a triangle on both sides
  };
  std::vector<Fan> fan_;       // per vertex
  std::vector<float> aside_;   // per vertex: sin θ
  std::vector<Vec3f> normal_;  // per triangle; zero where it has no area
  std::vector<Vec3f> corner_;  // per triangle: cosines of its corners
  std::vector<Vec3f> beyond_;  // per triangle, [m]
};

}  // namespace brim
