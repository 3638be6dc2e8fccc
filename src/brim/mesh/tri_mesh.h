#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "brim/math/types.h"

namespace brim {

using Triangle = std::array<std::int32_t, 3>;
using Tetrahedron = std::array<std::int32_t, 4>;

/// Triangle surface. Corners counter-clockwise seen from outside.
struct TriMesh {
  std::vector<Vec3> vertices;       ///< [m], shape (nv)
  std::vector<Triangle> triangles;  ///< vertex indices, shape (nt, 3)
};

/// Tetrahedra, each with positive volume: det(x1−x0, x2−x0, x3−x0) > 0.
struct TetMesh {
  std::vector<Vec3> vertices;     ///< [m], shape (nv)
  std::vector<Tetrahedron> tets;  ///< vertex indices, shape (ne, 4)
};

}  // namespace brim
