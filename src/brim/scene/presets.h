#pragma once

#include <string>
#include <vector>

#include "brim/scene/document.h"

namespace brim {

class ErrorList;

/// Replaces "preset" on bodies, materials and pairs of materials by the numbers of the named material
/// (schema/presets.json, each with its source); keys given beside it take precedence.
///   {"kind": "cloth", "preset": "cotton", ...}   "materials": {"tyre": {"preset": "rubber"}}
/// Unknown presets, and presets without data for the kind of body, are collected in `errors`.
/// Tests: tests/scene/parameters_test.cpp
void apply_presets(Document& document, ErrorList& errors);

/// Names of the presets for "materials".
std::vector<std::string> material_preset_names();

/// The presets, as in the file.
const Json& material_presets();
const std::string& material_presets_text();

}  // namespace brim
