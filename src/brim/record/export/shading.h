#pragma once

#include <span>
#include <vector>

#include "brim/math/types.h"
#include "brim/mesh/tri_mesh.h"

namespace brim::exporting {

/// A surface with vertices duplicated along creases, so that normals can be smooth on either side.
struct SplitMesh {
  std::vector<std::int32_t> source;                     ///< split vertex -> vertex
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< over split vertices
};

/// Splits where neighbouring triangles meet at more than an angle. Triangles around a vertex that are connected by
/// smooth edges share it. @param crease  [rad]
SplitMesh split_at_creases(std::span<const Vec3f> x, std::span<const Triangle> triangles, double crease);

/// Positions of the split vertices and their area-weighted unit normals; (0, 0, 1) where the area is zero.
void shade(const SplitMesh& mesh, std::span<const Vec3f> x, std::vector<Vec3f>& positions, std::vector<Vec3f>& normals);

}  // namespace brim::exporting
