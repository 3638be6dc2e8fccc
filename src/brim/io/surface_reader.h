#pragma once

#include <filesystem>
#include <string>

#include "brim/mesh/tri_mesh.h"

namespace brim {

/// Reads a surface from OBJ, PLY, OFF (read by brim), STL, glTF or GLB (by Assimp): polygons become triangles, vertices
/// at equal positions are joined, node transforms are applied; normals, textures and materials are left out. Lengths as
/// in the file, taken as metres; positions have single precision. Triangles with two equal corners are dropped.
/// @throws InputError  with the path and the reason: missing, unknown format, not readable, no triangles, a vertex that
/// is
///                     not finite, only triangles without area
/// Tests: tests/io/surface_reader_test.cpp
TriMesh read_surface(const std::filesystem::path& path);

/// What read_surface does with triangles that it has read: checks them, rounds positions to single precision, joins
/// equal vertices and drops those that no triangle uses. Order is kept.
/// @param name  for messages  @throws InputError
TriMesh clean_surface(TriMesh soup, const std::string& name);

}  // namespace brim
