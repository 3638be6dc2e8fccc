#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace brim::testing {

/// The bytes of a file; empty when it cannot be read.
inline std::string text_of(const std::filesystem::path& path) {
  std::ostringstream out;
  out << std::ifstream(path, std::ios::binary).rdbuf();
  return out.str();
}

}  // namespace brim::testing
