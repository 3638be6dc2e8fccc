#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace brim {

/// Pairs of parts that rows connected in the last sub-step. What rows hold turns and slides along them; other pairs
/// only come nearer, and may move farther in a sub-step. At the start of a world nothing is known, and all count as
/// held.
class HeldPairs {
 public:
  HeldPairs() = default;
  /// @param pairs  the smaller number first, in order
  explicit HeldPairs(std::vector<std::pair<std::int32_t, std::int32_t>> pairs)
      : all_(false), pairs_(std::move(pairs)) {}

  bool contains(std::int32_t a, std::int32_t b) const {
    return all_ || std::ranges::binary_search(pairs_, std::pair(std::min(a, b), std::max(a, b)));
  }

 private:
  bool all_ = true;
  std::vector<std::pair<std::int32_t, std::int32_t>> pairs_;
};

}  // namespace brim
