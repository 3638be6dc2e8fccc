#pragma once

#include <span>
#include <vector>

#include "brim/body/grid_fluid/mac_grid.h"

namespace brim {

/// The cells of a grid where the fluid is touched: cells of given points, and their face neighbours.
class TouchedCells {
 public:
  /// @param points  [m] where it is touched; outside points count for the nearest cell
  /// @param by_fluid  nonzero when the other side is a fluid; shape (points), or empty
  void note(const MacGrid& grid, std::span<const Vec3> points, std::span<const std::uint8_t> by_fluid = {});
  bool has(int cell) const { return !touched_.empty() && touched_[static_cast<std::size_t>(cell)] != 0; }
  bool has_fluid(int cell) const { return !touched_.empty() && touched_[static_cast<std::size_t>(cell)] == kByFluid; }

 private:
  static constexpr unsigned char kTouched = 1, kByFluid = 2;
  std::vector<unsigned char> touched_;  ///< shape (cells), or empty: nothing is touched
};

}  // namespace brim
