#include "brim/record/export/output_file.h"

#include "brim/core/error.h"

namespace brim::exporting {

OutputFile::OutputFile(const std::filesystem::path& path) : path_(path), file_(path, std::ios::binary) {
  if (!file_) fail();
}

void OutputFile::write(const void* data, std::size_t bytes) {
  file_.write(static_cast<const char*>(data), static_cast<std::streamsize>(bytes));
  if (!file_) fail();
  size_ += bytes;
}

void OutputFile::patch(std::uint64_t at, const void* data, std::size_t bytes) {
  file_.seekp(static_cast<std::streamoff>(at));
  file_.write(static_cast<const char*>(data), static_cast<std::streamsize>(bytes));
  file_.seekp(0, std::ios::end);
  if (!file_) fail();
}

void OutputFile::close() {
  file_.close();
  if (!file_) fail();
}

void OutputFile::fail() const {
  throw InputError(fmt::format("{}: cannot be written; is the disk full or the folder protected?", path_.string()));
}

}  // namespace brim::exporting
