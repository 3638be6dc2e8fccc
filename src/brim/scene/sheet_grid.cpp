#include "brim/scene/sheet_grid.h"

#include "brim/scene/limits.h"

namespace brim {

SheetGrid read_sheet_grid(const Node& grid, double scale, double bytes, double limit) {
  const Json& size = grid.json().at("size");
  const std::vector<int> cells = grid.at("cells").integers();
  check_count(grid.at("cells"), 1.0 * cells[0] * cells[1], bytes, limit, "cells");
  const int row = cells[0] + 1;
  return {cells[0],
          cells[1],
          scale * size[0].get<double>(),
          scale * size[1].get<double>(),
          {0, cells[0], cells[1] * row, cells[1] * row + cells[0]}};
}

}  // namespace brim
