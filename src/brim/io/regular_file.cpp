#include "brim/io/regular_file.h"

#include <filesystem>
#include <fstream>
#include <iterator>

#include "brim/core/error.h"

namespace brim {

namespace fs = std::filesystem;

void need_regular_file(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) throw InputError(path + ": cannot be opened");
  if (!fs::is_regular_file(status)) throw InputError(path + ": not a file");
}

std::optional<std::string> read_regular_file(const std::string& path, std::uint64_t most) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return {};
  if (const auto size = fs::file_size(path, error); !error && size > most)
    throw InputError(fmt::format("{}: {} bytes; at most {} are allowed", path, size, most));
  std::ifstream in(path, std::ios::binary);
  if (!in) return {};
  return std::string(std::istreambuf_iterator<char>(in), {});
}

}  // namespace brim
