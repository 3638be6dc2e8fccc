#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "brim/record/column.h"

namespace brim {

/// A column of a list, as it lies in the file.
struct ListColumn {
  const char* name;
  h5::Type type;
  std::uint64_t width;  ///< numbers of a row; 0: a plain number
};

/// Lists that differ in length from frame to frame: in a group of a run, the rows of all frames one after another in
/// every column, and in `offset` where each frame's rows start.
/// Tests: tests/record/run_test.cpp
class RaggedList {
 public:
  RaggedList() = default;
  /// Makes the group (create), or opens it. @param chunk  rows of a chunk
  RaggedList(h5::File& file, const std::string& group, std::span<const ListColumn> columns, std::uint64_t chunk,
             bool create);

  /// Appends to column c what get(item, target) gathers of every item of a list.
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
  /// Appends to column c rows as they lie in the file.
  void append_rows(std::size_t c, const void* data, std::size_t rows) { columns_[c].append(data, rows); }
  /// Ends a frame that has added `rows` rows to every column.
  void close_frame(std::size_t rows);
  /// Drops all frames from `frames` on.
  void cut(std::uint64_t frames);
  /// Rows of all frames.
  std::int64_t total() const { return total_; }
  /// Of frames first to first + count - 1, as flushed: where the rows of each start, and where the last ones end.
  std::vector<std::int64_t> offsets(std::uint64_t first, std::uint64_t count) const;
  void flush();

 private:
  Column offset_;
  std::vector<Column> columns_;
  std::int64_t total_ = 0;
  std::vector<std::byte> room_;
};

}  // namespace brim
