#pragma once

#include "brim/scene/document.h"
#include "brim/scene/errors.h"

namespace brim {

/// Puts the bodies of other scene files behind those of this one, with their materials, pairs of materials, groups,
/// filters, attachments, joints, forces, sensors and edits of timelines, and takes "include" out of the root:
///   "include": [{"file": "table.json", "prefix": "left_", "transform": {...}, "set": {"height": 0.7}}]
/// All names get the prefix, also in patterns; a force on no bodies in particular is one on those of its file that can
/// move; what has a place or a direction moves with the transform; relative paths become
/// relative to this file's folder. The world, the length and the expectations are those of the including scene.
/// Included scenes may include others, up to 8 deep.
/// @param errors  what is known to be wrong: entries that it touches are passed over
/// @return  true when there was something to include
/// @throws InputError, InputErrors  also for scenes that include themselves
/// Tests: tests/scene/include_test.cpp
bool apply_includes(Document& document, const ErrorList& errors);

}  // namespace brim
