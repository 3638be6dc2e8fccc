#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace brim {

/// Row starts of a subset of a sparse matrix's rows.
/// @param row_start  of all rows, shape (all rows + 1)  @param starts  shape (rows + 1), overwritten
inline void pick_row_starts(std::span<const std::int32_t> row_start, std::span<const std::uint32_t> rows,
                            std::vector<std::int32_t>& starts) {
  starts.resize(rows.size() + 1);
  starts[0] = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) starts[i + 1] = starts[i] + row_start[rows[i] + 1] - row_start[rows[i]];
}

}  // namespace brim
