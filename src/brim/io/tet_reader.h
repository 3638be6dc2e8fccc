#pragma once

#include <filesystem>
#include <string>

#include "brim/mesh/tri_mesh.h"

namespace brim {

/// Reads the tetrahedra of a Gmsh file (.msh, 2.2 ASCII or binary, 4.1 ASCII) or a legacy VTK unstructured grid (.vtk,
/// ASCII or BINARY). Other element kinds are skipped; unused vertices are dropped. If all tetrahedra are inverted (some
/// programs use the other orientation), all are flipped; if only some are, the file is rejected.
/// @throws InputError  with the path and the reason: missing, unknown kind or version, truncated, an index out of
///                     range, a non-finite vertex, no tetrahedra, k inverted or flat tetrahedra (count and first index)
/// Tests: tests/io/tet_reader_test.cpp
TetMesh read_tets(const std::filesystem::path& path);

/// Checks and cleans tetrahedra as read_tets does: flips all inverted ones, drops unused vertices.
/// @param name  for messages  @throws InputError
TetMesh clean_tets(const TetMesh& mesh, const std::string& name);

}  // namespace brim
