#pragma once

#include <span>
#include <vector>

#include "brim/body/grid_fluid/mac_grid.h"

namespace brim {

/// How near a grid's cells are to where the fluid is touched: 1 within two cells, as far as the flow through the
/// surface at a contact is gathered from, and from there to 0 over two more. Ways are counted from cell to cell along
/// the axes.
class TouchedCells {
 public:
  /// @param points  [m] where it is touched; those outside count for the nearest cell
  void note(const MacGrid& grid, std::span<const Vec3> points);
  /// [-] of a cell.
  double nearness(int cell) const { return nearness_.empty() ? 0.0 : nearness_[static_cast<std::size_t>(cell)]; }

 private:
  std::vector<float> nearness_;  ///< shape (cells), or empty: nothing touches
  std::vector<int> front_, next_;
};

}  // namespace brim
