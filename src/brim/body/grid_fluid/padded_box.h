#pragma once

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "brim/math/types.h"

namespace brim {

/// Layout of a box of cells in memory with one cell of padding around it, so that kernels need no boundary tests and
/// may process eight cells of a row at a time: the padding after each row holds zeros and is never changed.
///
///   ........ | row of n.x cells, gap | ... |   rows of a plane, then those of the next; one row and one plane of gaps
struct PaddedBox {
  static constexpr std::size_t kLanes = 8;

  Vec3i n = Vec3i::Zero();
  std::size_t row = 0, plane = 0;  ///< strides along y and z
  std::size_t size = 0;            ///< length of an array, padding included

  PaddedBox() = default;
  explicit PaddedBox(const Vec3i& cells) : n(cells) {
    row = (static_cast<std::size_t>(n.x()) + kLanes) / kLanes * kLanes;
    plane = row * (static_cast<std::size_t>(n.y()) + 2);
    size = plane * (static_cast<std::size_t>(n.z()) + 2) + 2 * kLanes;
  }
  std::size_t at(int i, int j, int k) const {
    return kLanes + static_cast<std::size_t>(i) + row * static_cast<std::size_t>(j + 1) +
           plane * static_cast<std::size_t>(k + 1);
  }
  /// Start of the row that contains a place, and the row's (j, k).
  std::size_t row_of(std::size_t place) const { return place - (place - kLanes) % row; }
  std::pair<int, int> place_of(std::size_t first) const {
    const std::size_t r = (first - kLanes) / row, rows = static_cast<std::size_t>(n.y()) + 2;
    return {static_cast<int>(r % rows) - 1, static_cast<int>(r / rows) - 1};
  }
  /// Calls f(place, cell): the index of a cell in a padded array, and in one without padding, x fastest.
  template <class F>
  void for_cells(const F& f) const {
    std::size_t c = 0;
    for (int k = 0; k < n.z(); ++k)
      for (int j = 0; j < n.y(); ++j) {
        const std::size_t first = at(0, j, k);
        for (int i = 0; i < n.x(); ++i, ++c) f(first + static_cast<std::size_t>(i), c);
      }
  }
};

/// Symmetric matrix with the seven-point pattern of a box of cells, cells numbered x fastest:
///   (A x)_c = d_c x_c − Σ_neighbours a_cn x_n,     a >= 0, d_c >= Σ a_cn
struct GridMatrix {
  Vec3i n = Vec3i::Zero();
  std::vector<double> diagonal;                 ///< d, shape (cells); 0: no unknown
  std::array<std::vector<double>, 3> coupling;  ///< a with the next cell along x, y, z, shape (cells)

  void reset(const Vec3i& cells) {
    n = cells;
    const auto count = static_cast<std::size_t>(n.x()) * n.y() * n.z();
    diagonal.assign(count, 0.0);
    for (auto& a : coupling) a.assign(count, 0.0);
  }
};

}  // namespace brim
