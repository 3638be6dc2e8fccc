#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace brim {

/// The columns of a sparse matrix given by rows: lets Jᵀ be applied as a gather, parallel and in a fixed order.
struct RowTranspose {
  /// One appearance of a column.
  struct Entry {
    std::int32_t row;    ///< row (contact point)
    std::int32_t index;  ///< place in the row-wise list of entries
  };

  std::vector<std::int32_t> columns;  ///< columns that appear, ascending
  std::vector<std::int32_t> first;    ///< where the entries of columns[c] start, shape (columns.size() + 1)
  std::vector<Entry> entries;         ///< by column, then by row

  /// @param row_start  shape (rows + 1)
  /// @param column     of each entry, in [0, column_count)
  void build(std::size_t column_count, std::span<const std::int32_t> row_start, std::span<const std::int32_t> column);

  std::span<const Entry> of(std::size_t c) const {
    return std::span(entries).subspan(first[c], static_cast<std::size_t>(first[c + 1] - first[c]));
  }

 private:
  std::vector<std::int32_t> slot_;
};

}  // namespace brim
