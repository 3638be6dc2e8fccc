#include "brim/record/column.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace brim {

// Chunks are written as they lie in memory.
static_assert(std::endian::native == std::endian::little);

namespace {

std::size_t bytes_of(h5::Type type) {
  switch (type) {
    case h5::Type::Float64:
    case h5::Type::Int64:
      return 8;
    case h5::Type::Float32:
    case h5::Type::Int32:
      return 4;
    case h5::Type::UInt8:
      return 1;
  }
  return 1;
}

}  // namespace

std::uint64_t frame_chunk(std::size_t row_bytes) {
  return std::clamp<std::uint64_t>((std::uint64_t{1} << 16) / std::max<std::size_t>(row_bytes, 1), 1, 256);
}

Column::Column(h5::Dataset set) : set_(std::move(set)) { open(); }

Column::Column(h5::File& file, const std::string& path, h5::Type type, const std::vector<std::uint64_t>& row,
               std::uint64_t chunk_rows)
    : set_(file.growing(path, type, row, chunk_rows, 0)) {
  open();
}

void Column::open() {
  const std::vector<std::uint64_t> shape = set_.shape();
  rows_ = in_file_ = shape[0];
  chunk_ = set_.chunk_rows();
  row_ = bytes_of(set_.type());
  for (std::size_t a = 1; a < shape.size(); ++a) row_ *= shape[a];
  load_tail();
}

void Column::load_tail() {
  const std::uint64_t first = rows_ / chunk_ * chunk_;
  tail_.clear();
  if (row_ == 0 || first == rows_) return;
  tail_.resize((rows_ - first) * row_);
  set_.read(tail_.data(), tail_.size() / bytes_of(set_.type()), first, rows_ - first, set_.type());
}

void Column::write(std::uint64_t first, const void* data) {
  if (in_file_ < first + 1) set_.set_rows(in_file_ = first + 1);
  set_.write_chunk(first, data, chunk_ * row_);
}

void Column::append(const void* data, std::uint64_t rows) {
  if (rows == 0) return;
  const auto* from = static_cast<const std::byte*>(data);
  rows_ += rows;
  changed_ = true;
  if (row_ == 0) return;
  const std::size_t chunk_bytes = chunk_ * row_;
  std::size_t bytes = rows * row_;
  while (bytes > 0) {
    const std::uint64_t first = rows_ - (bytes + tail_.size()) / row_;
    if (tail_.empty() && bytes >= chunk_bytes) {
      write(first, from);
      from += chunk_bytes;
      bytes -= chunk_bytes;
      continue;
    }
    const std::size_t part = std::min(bytes, chunk_bytes - tail_.size());
    tail_.insert(tail_.end(), from, from + part);
    from += part;
    bytes -= part;
    if (tail_.size() < chunk_bytes) continue;
    write(first, tail_.data());
    tail_.clear();
  }
}

void Column::flush() {
  if (!changed_) return;
  changed_ = false;
  if (!tail_.empty()) {
    const std::size_t used = tail_.size();
    tail_.resize(chunk_ * row_);  // the rest of the chunk is zeros until it is written again
    write(rows_ - used / row_, tail_.data());
    tail_.resize(used);
  }
  if (in_file_ != rows_) set_.set_rows(in_file_ = rows_);
}

void Column::cut(std::uint64_t rows) {
  if (rows >= rows_) return;
  flush();
  set_.cut(rows);
  rows_ = in_file_ = rows;
  load_tail();
}

}  // namespace brim
