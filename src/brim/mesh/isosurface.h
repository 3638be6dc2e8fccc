#pragma once

#include <functional>
#include <span>

#include "brim/mesh/tri_mesh.h"

namespace brim {

/// A regular grid of node values for extracting a level surface.
struct ScalarLattice {
  Vec3 origin;                    ///< [m]
  double spacing;                 ///< [m]
  Vec3i nodes;                    ///< number of nodes along x, y, z
  std::span<const float> values;  ///< shape (nz, ny, nx), x fastest; negative inside
};

/// Position of the surface on an edge from an inside node (first) to an outside node (second), as a fraction in [0, 1].
using EdgeCut =
    std::function<double(const Vec3& inside, const Vec3& outside, double value_inside, double value_outside)>;

/// Level surface between negative nodes and the others, by marching six tetrahedra per cube; outward. It is closed when
/// all nodes on the border are outside, and always oriented and free of holes.
/// @param cut  empty: linear interpolation of the values
/// Tests: tests/mesh/distance_grid_test.cpp
TriMesh isosurface(const ScalarLattice& lattice, const EdgeCut& cut = {});

}  // namespace brim
