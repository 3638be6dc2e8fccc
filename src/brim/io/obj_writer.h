#pragma once

#include <filesystem>

#include "brim/mesh/tri_mesh.h"

namespace brim {

/// Writes a surface as Wavefront OBJ, with digits enough to read the same doubles back.
/// The file appears whole or not at all.
/// @throws InputError  when the file cannot be written
/// Tests: tests/io/surface_reader_test.cpp
void write_obj(const std::filesystem::path& path, const TriMesh& mesh);

}  // namespace brim
