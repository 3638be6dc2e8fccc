#pragma once

#include "brim/scene/document.h"

namespace brim {

class ErrorList;

/// Puts the numbers of named materials (schema/presets.json, each with its source) in place of "preset", on bodies, on
/// materials and on pairs of materials; keys that are given beside it win.
///   {"kind": "cloth", "preset": "cotton", ...}   "materials": {"tyre": {"preset": "rubber"}}
/// Unknown presets, and those that say nothing about such a kind of body, are collected in `errors`.
/// Tests: tests/scene/parameters_test.cpp
void apply_presets(Document& document, ErrorList& errors);

/// The presets, as in the file.
const Json& material_presets();
const std::string& material_presets_text();

}  // namespace brim
