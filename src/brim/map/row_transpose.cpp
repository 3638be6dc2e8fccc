#include "brim/map/row_transpose.h"

namespace brim {

void RowTranspose::count(std::size_t column_count, std::span<const std::int32_t> column) {
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
}

void RowTranspose::build(std::size_t column_count, std::span<const std::int32_t> row_start,
                         std::span<const std::int32_t> column) {
  entries.resize(column.size());
  build(column_count, row_start, column, [&](std::int32_t slot, std::int32_t row, std::int32_t index) {
    entries[slot] = {row, index};
  });
}

}  // namespace brim
