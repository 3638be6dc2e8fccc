#pragma once

#include <string>

#include "brim/mesh/tri_mesh.h"

namespace brim {

/// Triangles of a file that Assimp reads, in a process of its own (ChildReader): damaged files bring it to leaks, to
/// gigabytes and to loops. Indices are as the file has them. @throws InputError
TriMesh read_by_assimp(const std::string& path, const std::string& extension);

}  // namespace brim
