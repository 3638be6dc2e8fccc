#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "brim/math/types.h"

namespace brim {

/// Finds the overlapping pairs among many boxes (sweep and prune): sorted along the axis on which their centres spread
/// most, each box is tested against those that begin before it ends, eight at a time in single precision rounded
/// outwards, then exactly. Boxes may be unbounded; a box with NaN overlaps nothing. Tests:
/// tests/math/box_sweep_test.cpp
class BoxSweep {
 public:
  /// O(n log n); O(n) when the number of boxes is that of the last call and their order has hardly changed. The boxes
  /// must stay in place until the last call of partners().
  /// @param group  group of each box; boxes of one group are not tested against each other; empty for no groups
  void build(std::span<const Aabb> boxes, std::span<const std::int32_t> group = {});
  std::size_t size() const { return order_.size(); }
  /// The box at position i of the sorted order.
  std::int32_t at(std::size_t i) const { return order_[i]; }
  /// Appends the boxes that overlap the box at position i and follow it in the order, so each pair is found once.
  /// Thread-safe.
  void partners(std::size_t i, std::vector<std::int32_t>& out) const;

 private:
  template <class Less>
  void sort(const Less& less);

  std::span<const Aabb> boxes_;
  std::vector<std::int32_t> order_;  ///< kept between builds as the initial order
  std::vector<double> key_;          ///< lower bound along the axis, by box
  /// Bounds in the sorted order, along the other two axes in single precision; padded to whole vectors with empty
  /// boxes.
  std::vector<double> lo_;
  std::vector<float> across_[4];     // lower and upper bounds along the first other axis, then along the second
  std::vector<std::int32_t> group_;  // in the sorted order
  int axis_ = 0;
};

}  // namespace brim
