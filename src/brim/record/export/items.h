#pragma once

#include <vector>

#include "brim/record/export/format.h"

namespace brim::exporting {

/// The chosen bodies with names that files and formats can carry, and the viewer's colours.
std::vector<Item> make_items(const RunReader& run, const std::vector<int>& bodies);

}  // namespace brim::exporting
