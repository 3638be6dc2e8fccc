#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <span>
#include <vector>

namespace brim {

/// Columns of a sparse matrix stored by rows: Jᵀ is applied as a gather, in parallel and in a fixed order.
struct RowTranspose {
  /// One occurrence of a column.
  struct Entry {
    std::int32_t row;    ///< row (contact point)
    std::int32_t index;  ///< index in the row-wise list of entries
  };

  std::vector<std::int32_t> columns;  ///< columns that occur, ascending
  std::vector<std::int32_t> first;    ///< where the entries of columns[c] start, shape (columns.size() + 1)
  std::vector<Entry> entries;         ///< by column, then by row

  /// @param row_start  shape (rows + 1)
  /// @param column     of each entry, in [0, column_count)
  void build(std::size_t column_count, std::span<const std::int32_t> row_start, std::span<const std::int32_t> column);
  /// Finds only columns and first, and calls place(slot, row, index) for each entry, slot: its index in `entries`.
  template <class Place>
  void build(std::size_t column_count, std::span<const std::int32_t> row_start, std::span<const std::int32_t> column,
             const Place& place) {
    count(column_count, column);
    for (std::size_t r = 0; r + 1 < row_start.size(); ++r)
      for (std::int32_t e = row_start[r]; e < row_start[r + 1]; ++e)
        place(slot_[column[e]]++, static_cast<std::int32_t>(r), e);
  }

  std::span<const Entry> of(std::size_t c) const {
    return std::span(entries).subspan(first[c], static_cast<std::size_t>(first[c + 1] - first[c]));
  }

 private:
  /// Counting pass of a counting sort by column, stable in the rows.
  void count(std::size_t column_count, std::span<const std::int32_t> column);

  std::vector<std::int32_t> slot_;
};

/// Shares of a map's rows by particle, in the order in which Jᵀ reads them, built on first use: maps that only apply J
/// never need them. Thread-safe.
template <class Share>
class RowShares {
 public:
  RowTranspose transpose;     ///< columns and first only
  std::vector<Share> shares;  ///< by column, then by row

  /// To be called when the rows have changed.
  void forget() { made_ = false; }
  /// @param share  share(row, index) makes the share of an entry
  template <class F>
  void make(std::size_t column_count, std::span<const std::int32_t> row_start, std::span<const std::int32_t> column,
            const F& share) {
    if (made_) return;
    const std::lock_guard lock(making_);
    if (made_) return;
    shares.resize(column.size());
    transpose.build(column_count, row_start, column,
                    [&](std::int32_t slot, std::int32_t row, std::int32_t index) { shares[slot] = share(row, index); });
    made_ = true;
  }
  std::span<const Share> of(std::size_t c) const {
    return std::span(shares).subspan(transpose.first[c],
                                     static_cast<std::size_t>(transpose.first[c + 1] - transpose.first[c]));
  }

 private:
  std::atomic<bool> made_ = false;
  std::mutex making_;
};

}  // namespace brim
