#pragma once

#include <map>
#include <string>

#include "brim/scene/node.h"
#include "brim/world/world.h"

namespace brim {

/// The value of "response"; Inherit if absent or "automatic".
Response read_response(const Node& n);

/// "materials" of a scene, and those that are always there: "default", and "fluid", that of fluids. Tests:
/// tests/scene/parameters_test.cpp, tests/scene/bad_scenes_test.cpp
std::map<std::string, Material> read_materials(const Node& n);

/// The material of a body of this kind whose entry names none; as its schema says.
std::string material_of_kind(const std::string& kind);

/// @throws InputError when `name` (a value at `n`) is not a material
void need_material(const Node& n, const std::string& name, const std::map<std::string, Material>& materials);

/// Adds an entry of "pairs" to the options. @throws InputError
void read_pair(const Node& pair, const std::map<std::string, Material>& materials, WorldOptions& world);

}  // namespace brim
