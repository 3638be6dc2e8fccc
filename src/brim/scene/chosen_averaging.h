#pragma once

#include "brim/mesh/tri_mesh.h"
#include "brim/scene/node.h"

namespace brim {

/// Size of an elastic solid and of its elements.
struct SolidSize {
  double volume;   ///< [m³]
  double area;     ///< [m²] of its surface
  Vec3 extent;     ///< [m] of its box
  double element;  ///< [m] edge

  /// The third side of the box that has this volume, this area and the two longest sides; or, if that is more, the
  /// thickness of a round or square bar of this volume and area, as far as it fits the box, [m].
  double thickness() const;
};

/// Of tetrahedra; the edge is that of a regular one of their mean volume.
SolidSize size_of(const TetMesh& mesh);

/// The key "averaging" of an elastic body, [-]. Where the scene leaves it out: `share` for a slender solid, which
/// bends, with too few elements across to bend by 95 % of theory without (docs/bodies/finite_elements.md), else 0.
/// @param enough  [-] elements across that suffice
/// Tests: tests/scene/chosen_averaging_test.cpp
double chosen_averaging(const Node& body, const SolidSize& size, double enough, double share);

}  // namespace brim
