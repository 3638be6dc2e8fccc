#include "brim/map/row_transpose.h"

namespace brim {

void RowTranspose::build(std::size_t column_count, std::span<const std::int32_t> row_start,
                         std::span<const std::int32_t> column) {
  // Counting sort by column; the row order within a column is kept.
  slot_.assign(column_count, 0);
  for (const std::int32_t c : column) ++slot_[c];
  columns.clear();
  first.clear();
  std::int32_t next = 0;
  for (std::size_t c = 0; c < column_count; ++c) {
    const std::int32_t n = slot_[c];
    if (n == 0) continue;
    columns.push_back(static_cast<std::int32_t>(c));
    first.push_back(next);
    slot_[c] = next;
    next += n;
  }
  first.push_back(next);
  entries.resize(column.size());
  for (std::size_t r = 0; r + 1 < row_start.size(); ++r)
    for (std::int32_t e = row_start[r]; e < row_start[r + 1]; ++e)
      entries[slot_[column[e]]++] = {static_cast<std::int32_t>(r), e};
}

}  // namespace brim
