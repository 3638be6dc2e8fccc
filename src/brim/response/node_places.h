#pragma once

#include <cstdint>
#include <unordered_map>

#include "brim/math/types.h"

namespace brim {

/// Numbers kept by node of the grid, to go from a node to those around it.
class NodePlaces {
 public:
  /// Forgets all. @param h  [m] step of the grid
  void reset(double h) {
    h_ = h;
    number_.clear();
  }
  /// @param node  [m], within 1e6 steps of the origin
  void set(const Vec3& node, std::size_t number) { number_[key_of(node, 0, 0, 0)] = number; }

  /// True as soon as f(number) is for a node at most so many steps away along each axis; always in the same order.
  template <class F>
  bool any_around(const Vec3& node, int steps, const F& f) const {
    if (number_.empty()) return false;
    for (int dx = -steps; dx <= steps; ++dx)
      for (int dy = -steps; dy <= steps; ++dy)
        for (int dz = -steps; dz <= steps; ++dz)
          if (const auto it = number_.find(key_of(node, dx, dy, dz)); it != number_.end() && f(it->second)) return true;
    return false;
  }
  /// f(number) for all of them.
  template <class F>
  void for_around(const Vec3& node, int steps, const F& f) const {
    any_around(node, steps, [&](std::size_t number) {
      f(number);
      return false;
    });
  }

 private:
  std::int64_t key_of(const Vec3& node, int dx, int dy, int dz) const {
    const Vec3 i = (node / h_).array().round();
    constexpr std::int64_t kBias = 1 << 20;
    return ((static_cast<std::int64_t>(i.x()) + dx + kBias) << 42) +
           ((static_cast<std::int64_t>(i.y()) + dy + kBias) << 21) + static_cast<std::int64_t>(i.z()) + dz + kBias;
  }

  double h_ = 1.0;
  std::unordered_map<std::int64_t, std::size_t> number_;
};

}  // namespace brim
