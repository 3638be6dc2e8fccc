#pragma once

#include <vector>

#include "brim/io/file_cursor.h"
#include "brim/mesh/tri_mesh.h"

/// Parsers behind read_tets: the file's contents, unchecked. Used by tet_reader.cpp.
namespace brim {

/// Corners index `points`; −1 for a vertex tag that the file does not define.
struct RawTets {
  std::vector<Vec3> points;
  std::vector<std::array<std::int64_t, 4>> tets;
};

/// Gmsh .msh, 2.2 ASCII and binary, 4.1 ASCII. Second-order tetrahedra are reduced to their four corners.
RawTets parse_gmsh(FileCursor& file);

/// Legacy VTK unstructured grid, ASCII or BINARY (big-endian), cells in the form up to version 4.2 or from 5.0
/// (offsets).
RawTets parse_vtk(FileCursor& file);

}  // namespace brim
