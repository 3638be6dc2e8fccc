#include "brim/io/file_cursor.h"

#include <fstream>
#include <iterator>

namespace brim {

FileCursor::FileCursor(const std::filesystem::path& path) : name_(path.string()) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) fail("no such file");
  if (!std::filesystem::is_regular_file(path, ignored)) fail("not a file");
  std::ifstream file(path, std::ios::binary);
  data_.assign(std::istreambuf_iterator<char>(file), {});
  if (!file) fail("the file cannot be read");
  if (data_.empty()) fail("the file is empty");
}

}  // namespace brim
