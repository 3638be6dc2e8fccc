#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "brim/record/column.h"

namespace brim {

/// A column of a list in the file.
struct ListColumn {
  const char* name;
  h5::Type type;
  std::uint64_t width;  ///< numbers per row; 0: a scalar
};

/// Lists whose length varies from frame to frame: a group of the run with the rows of all frames concatenated in every
/// column, and the start of each frame's rows in `offset`.
/// Tests: tests/record/run_test.cpp
class RaggedList {
 public:
  RaggedList() = default;
  /// Creates the group (create), or opens it. @param chunk  rows per chunk
  RaggedList(h5::File& file, const std::string& group, std::span<const ListColumn> columns, std::uint64_t chunk,
             bool create);

  /// Appends to column c the values that get(item, target) collects for every item of a list.
  template <class T, class List, class Get>
  void append(std::size_t c, const List& list, std::size_t width, const Get& get) {
    room_.resize(list.size() * width * sizeof(T));
    T* at = reinterpret_cast<T*>(room_.data());
    for (const auto& item : list) {
      get(item, at);
      at += width;
    }
    columns_[c].append(room_.data(), list.size());
  }
  /// Appends rows in the file's format to column c.
  void append_rows(std::size_t c, const void* data, std::size_t rows) { columns_[c].append(data, rows); }
  /// Closes a frame that has added `rows` rows to every column.
  void close_frame(std::size_t rows);
  /// Drops all frames from `frames` on.
  void cut(std::uint64_t frames);
  /// Rows of all frames.
  std::int64_t total() const { return total_; }
  /// For frames first to first + count - 1, as flushed: start of each frame's rows, and the end of the last ones.
  std::vector<std::int64_t> offsets(std::uint64_t first, std::uint64_t count) const;
  void flush();

 private:
  Column offset_;
  std::vector<Column> columns_;
  std::int64_t total_ = 0;
  std::vector<std::byte> room_;
};

}  // namespace brim
