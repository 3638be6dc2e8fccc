#pragma once

#include <string>

#include "brim/mesh/tri_mesh.h"

namespace brim {

/// Triangles of a file read by Assimp in a separate process (ChildReader), as damaged files make Assimp leak, allocate
/// gigabytes or loop. Indices are those of the file. @throws InputError
TriMesh read_by_assimp(const std::string& path, const std::string& extension);

}  // namespace brim
