#pragma once

#include <map>
#include <string>

#include "brim/io/volume_reader.h"
#include "brim/mesh/tri_mesh.h"
#include "brim/scene/node.h"

namespace brim {

/// Meshes and volumes that a program passes to a scene in memory, by the name that the scene uses in place of a file.
struct GivenArrays {
  std::map<std::string, TriMesh> surfaces;    ///< after clean_surface
  std::map<std::string, TetMesh> tets;        ///< after clean_tets
  std::map<std::string, VolumeInfo> volumes;  ///< with their slices
};

/// The surface, tetrahedra or volume named by a value: a given one, or that of a file relative to the scene's folder.
/// @throws InputError  with the value's place
/// Tests: tests/scene/given_arrays_test.cpp
TriMesh named_surface(const Node& name);
TetMesh named_tets(const Node& name);
/// @param grid, series  of an OpenVDB file, of DICOM files (read_volume_info)
VolumeInfo named_volume(const Node& name, const std::string& grid, const std::string& series);

}  // namespace brim
