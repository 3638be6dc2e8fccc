#pragma once

#include <string>

#include "brim/record/run_reader.h"

namespace brim {

/// Rewrites the run in a folder in the present format, all frames; the old file is replaced at the end, atomically.
/// Needed to resume a run of an older version. The run must be one of this world.
/// @param world  is set to the recorded states in turn
/// @throws InputError
void upgrade_run(const std::string& folder, World& world);

}  // namespace brim
