#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

namespace brim {

/// Islands of connected bodies (union-find).  Tests: tests/world/islands_test.cpp
class Islands {
 public:
  /// Each body starts as an island of its own.
  explicit Islands(std::size_t bodies) : root_(bodies) { std::iota(root_.begin(), root_.end(), 0); }
  void join(std::int32_t a, std::int32_t b) {
    const std::int32_t i = first_of(a), j = first_of(b);
    root_[std::max(i, j)] = std::min(i, j);
  }
  /// Representative body of its island.
  std::int32_t first_of(std::int32_t body) {
    while (root_[body] != body) body = root_[body] = root_[root_[body]];
    return body;
  }
  /// Number of each body's island, counted from 0 in the order of their first bodies; shape (bodies).
  std::vector<std::int32_t> numbers() {
    std::vector<std::int32_t> number(root_.size());
    std::int32_t count = 0;
    for (std::size_t b = 0; b < root_.size(); ++b) {
      const std::int32_t first = first_of(static_cast<std::int32_t>(b));
      number[b] = static_cast<std::size_t>(first) == b ? count++ : number[first];
    }
    return number;
  }

 private:
  std::vector<std::int32_t> root_;
};

}  // namespace brim
