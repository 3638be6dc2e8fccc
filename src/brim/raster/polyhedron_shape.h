#pragma once

#include <memory>

#include "brim/mesh/convex_polyhedron.h"
#include "brim/raster/shape.h"

namespace brim {

/// Solid with the exact distance to a convex polyhedron, as boxes have it. Tests:
/// tests/raster/polyhedron_shape_test.cpp
std::shared_ptr<const Shape> make_polyhedron(ConvexPolyhedron solid);

}  // namespace brim
