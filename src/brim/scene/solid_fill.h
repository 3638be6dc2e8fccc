#pragma once

#include "brim/mesh/tri_mesh.h"
#include "brim/scene/node.h"

namespace brim {

/// A solid of tetrahedra from a scene: a "tet_mesh" file, or a "shape" filled with a lattice.
struct FilledSolid {
  TetMesh mesh;     ///< [m], the body's own frame, scaled
  TriMesh display;  ///< fine surface carried by it; empty: its boundary
  /// Volume of the shape over that of the tetrahedra, which cut off its sharp edges: with the density times this, the
  /// body has the mass of its shape. 1 where the tetrahedra were given or are to cover the shape.
  double volume_share = 1.0;
};

/// Checks keys that exclude or need each other: shape, tet_mesh, lattice_spacing; reads no files. Bodies without a
/// shape and a tet_mesh must not have a lattice_spacing. @throws InputError
void check_fill(const Node& body);

/// Reads or makes the tetrahedra of a body with "shape", "lattice_spacing" and "lattice", or "tet_mesh".
/// @param scale  [-] of all lengths  @param memory_limit  [bytes] of the scene
/// @throws InputError
FilledSolid read_filled(const Node& body, double scale, double memory_limit);

}  // namespace brim
