#pragma once

#include "brim/scene/document.h"

namespace brim {

/// Puts the bodies of other scene files behind those of this one, with their materials and pairs of materials, and
/// takes "include" out of the root:
///   "include": [{"file": "table.json", "prefix": "left_", "transform": {...}, "set": {"height": 0.7}}]
/// Names of bodies and materials get the prefix; what has a place moves with the transform; relative paths become
/// relative to this file's folder. The world, the length and the expectations are those of the including scene.
/// Included scenes may include others, up to 8 deep.
/// @return  true when there was something to include
/// @throws InputError, InputErrors  also for scenes that include themselves
/// Tests: tests/scene/include_test.cpp
bool apply_includes(Document& document);

}  // namespace brim
