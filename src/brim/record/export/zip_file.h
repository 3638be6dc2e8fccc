#pragma once

#include <string>
#include <vector>

#include "brim/record/export/output_file.h"

namespace brim::exporting {

/// An archive of stored (uncompressed) members of any size: ZIP with the 64-bit extension (APPNOTE 6.3, 4.3 to 4.5).
class ZipFile {
 public:
  explicit ZipFile(const std::filesystem::path& path) : file_(path) {}
  void begin(const std::string& name);
  void write(const void* data, std::size_t bytes);
  void end();
  /// Writes the directory, which completes the archive.
  void close();

 private:
  struct Member {
    std::string name;
    std::uint64_t at = 0, size = 0;
    std::uint32_t crc = 0;
  };
  OutputFile file_;
  std::vector<Member> members_;
};

}  // namespace brim::exporting
