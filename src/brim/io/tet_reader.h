#pragma once

#include <filesystem>
#include <string>

#include "brim/mesh/tri_mesh.h"

namespace brim {

/// Reads the tetrahedra of a Gmsh file (.msh, 2.2 ASCII or binary, 4.1 ASCII) or a legacy VTK unstructured grid (.vtk,
/// ASCII or BINARY). Other element kinds are skipped; vertices that no tetrahedron uses are dropped. If every
/// tetrahedron is inside out (some programs count the other way), all are turned; if only some are, the file is
/// refused.
/// @throws InputError  with the path and the reason: missing, unknown kind or version, truncated, an index out of
/// range,
///                     a vertex that is not finite, no tetrahedra, k inverted or flat tetrahedra (count and first
///                     index)
/// Tests: tests/io/tet_reader_test.cpp
TetMesh read_tets(const std::filesystem::path& path);

/// What read_tets does with tetrahedra that it has read: the checks, the turning, the dropping.
/// @param name  for messages  @throws InputError
TetMesh clean_tets(const TetMesh& mesh, const std::string& name);

}  // namespace brim
