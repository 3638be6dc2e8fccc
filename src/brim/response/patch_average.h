#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "brim/math/types.h"

namespace brim {

/// Points of a patch among the nodes of a coarse lattice: of each the eight lattice points around it, and their tent
/// weights. Fields are averaged over the patch by spreading them to the lattice and reading them back (PatchField). The
/// lattice is a dense array over the box of the points where that is not much larger than they are many, else it holds
/// the lattice points next to some point only. Memory is kept from patch to patch.
/// Tests: tests/response/patch_average_test.cpp
class PatchLattice {
 public:
  /// @param x       [m] the points
  /// @param cell    [m] lattice step (3h smooths over a patch without hiding its shape)
  /// @param origin  [m] of the lattice; taken from the points, it makes averages independent of where they are
  void place(std::span<const Vec3> x, double cell, const Vec3& origin);
  /// Lattice points that fields have values at.
  std::size_t size() const { return size_; }

  struct Place {
    std::array<std::int32_t, 8> slot;
    std::array<float, 8> weight;
  };
  const Place& operator[](std::size_t point) const { return place_[point]; }

 private:
  std::size_t size_ = 0;
  std::vector<Place> place_;
  std::vector<std::array<std::int64_t, 3>> base_;  ///< lattice point below each point
  std::vector<std::array<std::int64_t, 3>> used_;  ///< sorted, where the lattice is not dense
};

/// A field on a lattice. @tparam Value  a fixed-size Eigen array of floats
template <class Value>
class PatchField {
 public:
  void clear(std::size_t size) { value_.assign(size, Value::Zero()); }
  void add(const PatchLattice::Place& p, const Value& v) {
    for (int c = 0; c < 8; ++c) value_[p.slot[c]] += p.weight[c] * v;
  }
  /// The smoothed sum there.
  Value at(const PatchLattice::Place& p) const {
    Value sum = p.weight[0] * value_[p.slot[0]];
    for (int c = 1; c < 8; ++c) sum += p.weight[c] * value_[p.slot[c]];
    return sum;
  }

 private:
  std::vector<Value> value_;
};

}  // namespace brim
