#include "brim/scene/given_arrays.h"

#include "brim/io/surface_reader.h"
#include "brim/io/tet_reader.h"
#include "brim/scene/solid.h"

namespace brim {

namespace {

/// The entry of that name, or nothing where a file is meant.
template <class T>
const T* given(const Node& name, std::map<std::string, T> GivenArrays::*of) {
  const auto& arrays = name.document().arrays;
  if (!arrays) return nullptr;
  const auto it = ((*arrays).*of).find(name.string());
  return it == ((*arrays).*of).end() ? nullptr : &it->second;
}

}  // namespace

TriMesh named_surface(const Node& name) {
  if (const TriMesh* mesh = given(name, &GivenArrays::surfaces)) return *mesh;
  const std::string path = scene_path(name);
  return name.placed([&] { return read_surface(path); });
}

TetMesh named_tets(const Node& name) {
  if (const TetMesh* mesh = given(name, &GivenArrays::tets)) return *mesh;
  const std::string path = scene_path(name);
  return name.placed([&] { return read_tets(path); });
}

VolumeInfo named_volume(const Node& name, const std::string& grid, const std::string& series) {
  if (const VolumeInfo* info = given(name, &GivenArrays::volumes)) return *info;
  const std::string path = scene_path(name);
  return name.placed([&] { return read_volume_info(path, grid, series); });
}

}  // namespace brim
