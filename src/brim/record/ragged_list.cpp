#include "brim/record/ragged_list.h"

namespace brim {

namespace {

constexpr std::uint64_t kOffsetRows = 256;  // in a chunk

}  // namespace

RaggedList::RaggedList(h5::File& file, const std::string& group, std::span<const ListColumn> columns,
                       std::uint64_t chunk, bool create) {
  if (create) {
    file.group(group);
    offset_ = Column(file, group + "/offset", h5::Type::Int64, {}, kOffsetRows);
    close_frame(0);
  } else {
    offset_ = Column(file.open(group + "/offset"));
  }
  for (const ListColumn& c : columns) {
    const std::string path = group + "/" + c.name;
    const std::vector<std::uint64_t> row = c.width > 0 ? std::vector{c.width} : std::vector<std::uint64_t>{};
    columns_.push_back(create ? Column(file, path, c.type, row, chunk) : Column(file.open(path)));
  }
}

void RaggedList::close_frame(std::size_t rows) {
  total_ += static_cast<std::int64_t>(rows);
  offset_.append_value(total_);
}

void RaggedList::cut(std::uint64_t frames) {
  offset_.set().read(&total_, 1, frames, 1, h5::Type::Int64);
  for (Column& c : columns_) c.cut(static_cast<std::uint64_t>(total_));
  offset_.cut(frames + 1);
}

std::vector<std::int64_t> RaggedList::offsets(std::uint64_t first, std::uint64_t count) const {
  std::vector<std::int64_t> rows(count + 1);
  offset_.set().read(rows.data(), rows.size(), first, rows.size(), h5::Type::Int64);
  return rows;
}

void RaggedList::flush() {
  for (Column& c : columns_) c.flush();
  offset_.flush();
}

}  // namespace brim
