#pragma once

#include <filesystem>

#include "brim/mesh/tri_mesh.h"

namespace brim {

/// Writes a surface as Wavefront OBJ, with enough digits to read the same doubles back. The file is written atomically.
/// @throws InputError  when the file cannot be written
/// Tests: tests/io/surface_reader_test.cpp
void write_obj(const std::filesystem::path& path, const TriMesh& mesh);

}  // namespace brim
