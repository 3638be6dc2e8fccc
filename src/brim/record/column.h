#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "brim/record/h5.h"

namespace brim {

/// Rows that a run appends to one data set. They are kept until they fill a chunk, which is then written whole, so that
/// a frame costs copies in memory and few calls of HDF5; flush() writes the chunk that is not full yet, and the same
/// place is written again when it has grown.
///
///   file   | chunk 0 | chunk 1 | chunk 2 ...|    whole chunks, in plain bytes
///   tail_                      | rows so far |    the last chunk, rewritten by each flush
///
/// Tests: tests/record/column_test.cpp
class Column {
 public:
  Column() = default;
  /// @param set  new, or with rows that the column goes on from
  explicit Column(h5::Dataset set);
  /// Makes the data set. @param row  extents after the first; chunks hold up to `chunk_rows` rows
  Column(h5::File& file, const std::string& path, h5::Type type, const std::vector<std::uint64_t>& row,
         std::uint64_t chunk_rows);

  /// @param data  rows as they lie in the file: of the data set's own type, little-endian
  void append(const void* data, std::uint64_t rows);
  template <class T>
  void append_value(const T& value) {
    append(&value, 1);
  }
  /// Drops all rows from `rows` on.
  void cut(std::uint64_t rows);
  /// Writes what is kept. The rows are in the file after the next flush of the file itself.
  void flush();
  std::uint64_t rows() const { return rows_; }
  const h5::Dataset& set() const { return set_; }

 private:
  void open();
  void load_tail();
  void write(std::uint64_t first, const void* data);

  h5::Dataset set_;
  std::uint64_t rows_ = 0;     ///< in all
  std::uint64_t in_file_ = 0;  ///< first axis of the data set now
  std::uint64_t chunk_ = 1;    ///< rows of a chunk
  std::size_t row_ = 0;        ///< bytes
  std::vector<std::byte> tail_;
  bool changed_ = false;  ///< the tail since the last flush
};

/// Rows of about 64 kB together, at most 256: what a frame adds to each of the per-frame data sets.
std::uint64_t frame_chunk(std::size_t row_bytes);

}  // namespace brim
