#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "brim/math/types.h"

namespace brim {

/// Finds which of many boxes overlap: sorted along the axis on which their middles lie farthest apart, each is held
/// against those that begin before it ends, eight at a time in single precision rounded outwards, then exactly.
/// Boxes may be unbounded; what is no number overlaps nothing. Tests: tests/math/box_sweep_test.cpp
class BoxSweep {
 public:
  /// O(n log n); O(n) where as many boxes as last time have nearly kept their order. The boxes must stay where they are
  /// until the last call of partners().
  /// @param group  of each box: boxes of one group are not held against each other; empty where there are none
  void build(std::span<const Aabb> boxes, std::span<const std::int32_t> group = {});
  std::size_t size() const { return order_.size(); }
  /// The box at place i of the order.
  std::int32_t at(std::size_t i) const { return order_[i]; }
  /// Appends the boxes that overlap the one at place i and come after it in the order: each pair is found once.
  /// Safe to be called by several threads at once.
  void partners(std::size_t i, std::vector<std::int32_t>& out) const;

 private:
  template <class Less>
  void sort(const Less& less);

  std::span<const Aabb> boxes_;
  std::vector<std::int32_t> order_;  ///< kept from build to build, which starts from it
  std::vector<double> key_;          ///< least along the axis, by box
  /// Bounds in the order, along the other two axes in single precision; filled up to whole vectors by empty boxes.
  std::vector<double> lo_;
  std::vector<float> across_[4];     // least and largest of the one, then of the other
  std::vector<std::int32_t> group_;  // in the order
  int axis_ = 0;
};

}  // namespace brim
