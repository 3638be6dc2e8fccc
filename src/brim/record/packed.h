#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace brim {

/// Concatenated lists, and the start of each.
template <class T>
struct Packed {
  std::vector<T> items;
  std::vector<std::int64_t> first = {0};
  void add(std::span<const T> list) {
    items.insert(items.end(), list.begin(), list.end());
    first.push_back(static_cast<std::int64_t>(items.size()));
  }
  std::span<const T> at(std::size_t i) const {
    const auto from = static_cast<std::size_t>(first[i]);
    return std::span(items).subspan(from, static_cast<std::size_t>(first[i + 1]) - from);
  }
};

}  // namespace brim
