#pragma once

#include <malloc.h>

#include <cstddef>
#include <vector>

namespace brim::testing {

/// Bytes in use, of the main arena.
inline std::size_t bytes_in_use() {
  const auto info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

/// False with allocators that do not say what is in use, as those of sanitizers.
inline bool heap_is_measurable() {
  const std::size_t before = bytes_in_use();
  const std::vector<char> probe(100000, 'x');
  return bytes_in_use() >= before + probe.size();
}

}  // namespace brim::testing
