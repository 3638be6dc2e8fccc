#pragma once

#include <cstdint>
#include <vector>

#include "brim/scene/node.h"

namespace brim {

/// The "grid" of a sheet or net: nodes in rows along x.
struct SheetGrid {
  int nx = 0, ny = 0;                 ///< cells along x and y
  double lx = 0.0, ly = 0.0;          ///< [m] size, scaled
  std::vector<std::int32_t> corners;  ///< numbers of its four corner nodes
};

/// @param scale  [-] of all lengths
/// @param bytes  [bytes] per cell, with all data of a step  @param limit  [bytes] memory_limit of the scene
/// @throws InputError  for too many cells
SheetGrid read_sheet_grid(const Node& grid, double scale, double bytes, double limit);

}  // namespace brim
