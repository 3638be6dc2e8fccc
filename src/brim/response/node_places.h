#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "brim/math/types.h"

namespace brim {

/// Hash table from grid nodes to numbers, for searches around a node. Open addressing; memory is kept between uses.
/// Tests: tests/response/node_places_test.cpp
class NodePlaces {
 public:
  /// Empties the table. @param h  [m] step of the grid
  void reset(double h) {
    h_ = h, count_ = 0;
    // Slots of earlier generations count as empty.
    if (++generation_ == 0) slots_.assign(slots_.size(), {}), generation_ = 1;
  }
  /// @param node  [m], within 1e6 steps of the origin
  void set(const Vec3& node, std::size_t number) {
    if (2 * (count_ + 1) > slots_.size()) grow();
    const std::int64_t key = key_of(node);
    Slot& s = slot_of(key);
    count_ += s.generation != generation_;
    s = {key, static_cast<std::uint32_t>(number), generation_};
  }

  /// True when f(number) is true for a node at most `steps` steps away along each axis; stops at the first, in fixed
  /// order.
  template <class F>
  bool any_around(const Vec3& node, int steps, const F& f) const {
    if (count_ == 0) return false;
    const std::int64_t middle = key_of(node);
    for (std::int64_t dx = -steps; dx <= steps; ++dx)
      for (std::int64_t dy = -steps; dy <= steps; ++dy)
        for (std::int64_t dz = -steps; dz <= steps; ++dz) {
          const Slot& s = slot_of(middle + dx * kX + dy * kY + dz);
          if (s.generation == generation_ && f(std::size_t{s.number})) return true;
        }
    return false;
  }
  /// Calls f(number) for all these nodes.
  template <class F>
  void for_around(const Vec3& node, int steps, const F& f) const {
    any_around(node, steps, [&](std::size_t number) {
      f(number);
      return false;
    });
  }

 private:
  struct Slot {
    std::int64_t key = 0;
    std::uint32_t number = 0, generation = 0;
  };
  static constexpr std::int64_t kX = std::int64_t{1} << 42, kY = std::int64_t{1} << 21;

  std::int64_t key_of(const Vec3& node) const {
    const Vec3 i = (node / h_).array().round();
    constexpr std::int64_t kBias = 1 << 20;
    return (static_cast<std::int64_t>(i.x()) + kBias) * kX + (static_cast<std::int64_t>(i.y()) + kBias) * kY +
           static_cast<std::int64_t>(i.z()) + kBias;
  }
  /// Slot of the key, or the empty slot where it would be inserted.
  const Slot& slot_of(std::int64_t key) const {
    // Only the highest bits of the product depend on all of the key.
    const std::size_t mask = slots_.size() - 1;
    auto at = static_cast<std::size_t>((static_cast<std::uint64_t>(key) * 0x9e3779b97f4a7c15ull) >> shift_);
    while (slots_[at].generation == generation_ && slots_[at].key != key) at = (at + 1) & mask;
    return slots_[at];
  }
  Slot& slot_of(std::int64_t key) { return const_cast<Slot&>(static_cast<const NodePlaces&>(*this).slot_of(key)); }
  void grow() {
    std::vector<Slot> old(std::max<std::size_t>(64, 2 * slots_.size()));
    old.swap(slots_);
    shift_ = 64 - std::countr_zero(slots_.size());
    for (const Slot& s : old)
      if (s.generation == generation_) slot_of(s.key) = s;
  }

  double h_ = 1.0;
  std::vector<Slot> slots_;  ///< size a power of two, at least half of them empty
  std::size_t count_ = 0;
  std::uint32_t generation_ = 1;
  int shift_ = 58;  ///< 64 minus log2 of the number of slots
};

}  // namespace brim
