#pragma once

#include "brim/mesh/tri_mesh.h"

namespace brim {

/// True when all vertices lie in one plane of any orientation: within 1e-6 of their extent, the precision of files with
/// single-precision coordinates. Such a surface encloses nothing.  Tests: tests/mesh/flat_surface_test.cpp
bool is_flat(const TriMesh& mesh);

}  // namespace brim
