#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "brim/body/grid_fluid/mac_grid.h"
#include "brim/body/grid_fluid/wet_faces.h"

namespace brim {

/// The faces between wet and dry cells, by dry cell, and where the surface cuts the lines between their centres. Found
/// once for all points that ask for those around them: most of the 7x7x7 cells around a point have none.
/// Tests: tests/body/surface_faces_test.cpp
class SurfaceFaces {
 public:
  struct Cut {
    Vec3 cell;   ///< [cells] number of the dry cell along each axis
    double way;  ///< [cells] from its centre to the surface, along the axis
    std::int32_t face;
    std::int32_t axis;
    double sign;  ///< +1: the dry cell lies above the face
  };

  /// @param phi  [m] per cell; dry cells more than two cells from the surface have no cuts
  void find(const MacGrid& grid, const WetFaces& wet, std::span<const double> phi);

  /// Calls f(cut) for the cuts of dry cells [first, last], x fastest.
  template <class F>
  void for_cuts(const Vec3i& first, const Vec3i& last, const F& f) const {
    if (last.x() < first.x()) return;
    for (int k = first.z(); k <= last.z(); ++k)
      for (int j = first.y(); j <= last.y(); ++j) {
        const std::size_t row = static_cast<std::size_t>(n_.x()) * (j + static_cast<std::size_t>(n_.y()) * k);
        const std::int32_t end = start_[row + static_cast<std::size_t>(last.x()) + 1];
        for (std::int32_t c = start_[row + static_cast<std::size_t>(first.x())]; c < end; ++c)
          f(cuts_[static_cast<std::size_t>(c)]);
      }
  }

 private:
  Vec3i n_ = Vec3i::Zero();
  std::vector<std::int32_t> start_;  ///< of each cell's cuts, shape (cells + 1)
  std::vector<Cut> cuts_;
};

}  // namespace brim
