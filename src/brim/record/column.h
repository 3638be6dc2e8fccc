#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "brim/record/h5.h"

namespace brim {

/// Rows that a run appends to one data set. They are buffered until they fill a chunk, which is then written as a
/// whole, so that a frame costs memory copies and few HDF5 calls; flush() writes the incomplete last chunk, which is
/// rewritten in place when it has grown.
///
///   file   | chunk 0 | chunk 1 | chunk 2 ...|    whole chunks, in plain bytes
///   tail_                      | rows so far |    the last chunk, rewritten by each flush
///
/// Tests: tests/record/column_test.cpp
class Column {
 public:
  Column() = default;
  /// @param set  new, or with rows to be continued
  explicit Column(h5::Dataset set);
  /// Creates the data set. @param row  extents after the first; chunks hold up to `chunk_rows` rows
  Column(h5::File& file, const std::string& path, h5::Type type, const std::vector<std::uint64_t>& row,
         std::uint64_t chunk_rows);

  /// @param data  rows in the file's format: the data set's own type, little-endian
  void append(const void* data, std::uint64_t rows);
  template <class T>
  void append_value(const T& value) {
    append(&value, 1);
  }
  /// Drops all rows from `rows` on.
  void cut(std::uint64_t rows);
  /// Writes the buffered rows. They are in the file after the next flush of the file itself.
  void flush();
  std::uint64_t rows() const { return rows_; }
  const h5::Dataset& set() const { return set_; }

 private:
  void open();
  void load_tail();
  void write(std::uint64_t first, const void* data);

  h5::Dataset set_;
  std::uint64_t rows_ = 0;     ///< in all
  std::uint64_t in_file_ = 0;  ///< present first extent of the data set
  std::uint64_t chunk_ = 1;    ///< rows of a chunk
  std::size_t row_ = 0;        ///< bytes
  std::vector<std::byte> tail_;
  bool changed_ = false;  ///< tail_ changed since the last flush
};

/// Number of rows that make about 64 kB, at most 256: chunk size of the per-frame data sets.
std::uint64_t frame_chunk(std::size_t row_bytes);

}  // namespace brim
