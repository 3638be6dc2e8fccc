#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "brim/core/widest.h"
#include "brim/math/types.h"

namespace brim {

/// Points of a patch on a coarse lattice: for each point its eight lattice neighbours and their tent weights. Fields
/// are averaged over the patch by spreading them to the lattice and reading them back (PatchField). The lattice is a
/// dense array over the points' box unless that has far more lattice points than there are points; then only lattice
/// points next to a point are stored. Memory is kept from patch to patch.
/// Tests: tests/response/patch_average_test.cpp
class PatchLattice {
 public:
  /// @param x       [m] the points
  /// @param cell    [m] lattice step (3h smooths over a patch without hiding its shape)
  /// @param origin  [m] of the lattice; when taken from the points, averages are independent of their place
  void place(std::span<const Vec3> x, double cell, const Vec3& origin);
  /// Number of lattice points that store values.
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
  std::vector<std::array<std::int64_t, 3>> used_;  ///< sorted, when the lattice is not dense
};

/// A field on a lattice. @tparam Value  one float, or several processed together (core/widest.h)
template <class Value>
class PatchField {
 public:
  void clear(std::size_t size) { value_.assign(size * kFloats, 0.0f); }
  BRIM_INLINE void add(const PatchLattice::Place& p, const Value& v) {
    for (int c = 0; c < 8; ++c) {
      float* to = value_.data() + kFloats * p.slot[c];
      const Value sum = load(to) + p.weight[c] * v;
      std::memcpy(to, &sum, sizeof sum);
    }
  }
  /// The smoothed sum at a place.
  BRIM_INLINE Value at(const PatchLattice::Place& p) const {
    Value sum = p.weight[0] * load(value_.data() + kFloats * p.slot[0]);
    for (int c = 1; c < 8; ++c) sum += p.weight[c] * load(value_.data() + kFloats * p.slot[c]);
    return sum;
  }

 private:
  static constexpr std::size_t kFloats = sizeof(Value) / sizeof(float);
  BRIM_INLINE static Value load(const float* from) {
    Value v;
    std::memcpy(&v, from, sizeof v);
    return v;
  }

  std::vector<float> value_;
};

}  // namespace brim
