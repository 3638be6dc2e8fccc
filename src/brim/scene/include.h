#pragma once

#include "brim/scene/document.h"
#include "brim/scene/errors.h"

namespace brim {

/// Appends the bodies of other scene files to those of this one, with their materials, pairs of materials, groups,
/// filters, attachments, joints, forces, sensors and timeline edits, and removes "include" from the root:
///   "include": [{"file": "table.json", "prefix": "left_", "transform": {...}, "set": {"height": 0.7}}]
/// All names get the prefix, also in patterns; a force without named bodies acts on the movable bodies of its file;
/// positions and directions are transformed; relative paths become relative to this file's folder. World options,
/// length and expectations are those of the including scene.
/// Included scenes may include others, up to 8 deep.
/// @param errors  known errors: entries that they touch are skipped
/// @return  true when there was something to include
/// @throws InputError, InputErrors  also for scenes that include themselves
/// Tests: tests/scene/include_test.cpp
bool apply_includes(Document& document, const ErrorList& errors);

}  // namespace brim
