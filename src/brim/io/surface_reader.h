#pragma once

#include <filesystem>
#include <string>

#include "brim/mesh/tri_mesh.h"

namespace brim {

/// Reads a surface from OBJ, PLY, OFF (read by brim), STL, glTF or GLB (by Assimp): polygons become triangles, equal
/// vertices are merged, node transforms are applied; normals, textures and materials are ignored. Lengths as in the
/// file, taken as metres; positions have single precision. Triangles with two equal corners are dropped.
/// @throws InputError  with the path and the reason: missing, unknown format, not readable, no triangles, a non-finite
///                     vertex, only triangles of zero area
/// Tests: tests/io/surface_reader_test.cpp
TriMesh read_surface(const std::filesystem::path& path);

/// Checks and cleans triangles, as read_surface does: rounds positions to single precision, merges equal vertices and
/// drops unused ones. Order is kept.
/// @param name  for messages  @throws InputError
TriMesh clean_surface(TriMesh soup, const std::string& name);

}  // namespace brim
