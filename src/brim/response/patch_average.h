#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "brim/math/types.h"

namespace brim {

/// Smooth average of a field over a coarse lattice: samples are spread to the lattice with tent weights and read back
/// with the same weights. The lattice is a small hash table, rebuilt for each pair of parts.
template <class Value>
class PatchAverage {
 public:
  /// @param cell    [m] lattice step (3h smooths over a patch without hiding its shape)
  /// @param origin  [m] of the lattice; taken from the samples, it makes the average independent of where they are
  void reset(double cell, std::size_t samples, const Vec3& origin = Vec3::Zero()) {
    inverse_cell_ = 1.0 / cell;
    origin_ = origin;
    std::size_t capacity = 64;
    while (capacity < 2 * samples) capacity *= 2;  // few lattice points per sample; grows if that is wrong
    slot_.assign(capacity, -1);
    key_.clear();
    value_.clear();
  }

  void add(const Vec3& x, const Value& v) {
    visit(x, [&](std::uint64_t key, double weight) {
      const std::size_t s = find(key);
      if (slot_[s] < 0) {
        slot_[s] = static_cast<std::int32_t>(key_.size());
        key_.push_back(key);
        value_.push_back(weight * v);
        if (2 * key_.size() > slot_.size()) grow();
      } else {
        value_[slot_[s]] += weight * v;
      }
    });
  }

  /// The smoothed sum at x; zero far from every sample.
  Value at(const Vec3& x) const {
    Value sum = 0.0 * value_.front();
    visit(x, [&](std::uint64_t key, double weight) {
      const std::size_t s = find(key);
      if (slot_[s] >= 0) sum += weight * value_[slot_[s]];
    });
    return sum;
  }

 private:
  template <class F>
  void visit(const Vec3& x, const F& f) const {
    const Vec3 p = (x - origin_) * inverse_cell_;
    const Vec3 base = p.array().floor();
    const Vec3 t = p - base;
    for (int c = 0; c < 8; ++c) {
      const int i = c & 1, j = (c >> 1) & 1, k = c >> 2;
      const double weight = (i ? t.x() : 1 - t.x()) * (j ? t.y() : 1 - t.y()) * (k ? t.z() : 1 - t.z());
      f(pack(static_cast<std::int64_t>(base.x()) + i, static_cast<std::int64_t>(base.y()) + j,
             static_cast<std::int64_t>(base.z()) + k),
        weight);
    }
  }
  static std::uint64_t pack(std::int64_t i, std::int64_t j, std::int64_t k) {
    constexpr std::uint64_t mask = (1u << 21) - 1;
    return (static_cast<std::uint64_t>(i) & mask) | (static_cast<std::uint64_t>(j) & mask) << 21 |
           (static_cast<std::uint64_t>(k) & mask) << 42;
  }
  std::size_t find(std::uint64_t key) const {
    std::size_t s = (key * 0x9E3779B97F4A7C15ull >> 20) & (slot_.size() - 1);
    while (slot_[s] >= 0 && key_[slot_[s]] != key) s = (s + 1) & (slot_.size() - 1);
    return s;
  }
  void grow() {
    slot_.assign(2 * slot_.size(), -1);
    for (std::size_t i = 0; i < key_.size(); ++i) slot_[find(key_[i])] = static_cast<std::int32_t>(i);
  }

  double inverse_cell_ = 1.0;
  Vec3 origin_ = Vec3::Zero();
  std::vector<std::int32_t> slot_;
  std::vector<std::uint64_t> key_;
  std::vector<Value> value_;
};

}  // namespace brim
