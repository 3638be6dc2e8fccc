#pragma once

#include "brim/mesh/tri_mesh.h"

namespace brim {

/// True where all vertices lie in one plane, however it is turned: within 1e-6 of their spread, which files with
/// single-precision places keep. Such a surface encloses nothing.  Tests: tests/mesh/flat_surface_test.cpp
bool is_flat(const TriMesh& mesh);

}  // namespace brim
