#pragma once

#include <string>

#include "brim/record/run_reader.h"

namespace brim {

/// Writes the run in a folder anew in the format of today, all frames; the old file is replaced at the end, in one
/// step. A run of an older version that is gone on with needs it. The run must be one of such a world.
/// @param world  is set to the recorded states one after another
/// @throws InputError
void upgrade_run(const std::string& folder, World& world);

}  // namespace brim
