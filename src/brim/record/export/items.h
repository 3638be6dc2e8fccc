#pragma once

#include <vector>

#include "brim/record/export/format.h"

namespace brim::exporting {

/// The chosen bodies, with names that are valid in files and formats, and the viewer's colours.
std::vector<Item> make_items(const RunReader& run, const std::vector<int>& bodies);

}  // namespace brim::exporting
