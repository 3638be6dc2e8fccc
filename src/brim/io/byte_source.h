#pragma once

#include <cstddef>
#include <memory>
#include <string>

namespace brim {

/// The bytes of a file or of a gzip stream in it, read forward. Errors name the file.
class ByteSource {
 public:
  /// @param offset  where to start in the file, [bytes]
  /// @param gzip    the bytes there are a gzip stream, to be unpacked
  /// @throws InputError  when the file cannot be opened
  ByteSource(const std::string& path, std::size_t offset, bool gzip);
  ~ByteSource();
  ByteSource(ByteSource&&) noexcept;

  /// Reads exactly n bytes. @throws InputError  when there are fewer, or the compressed data are corrupt
  void read(void* to, std::size_t n);
  /// Reads up to n bytes; fewer only at the end.
  std::size_t read_some(void* to, std::size_t n);
  void skip(std::size_t n);

 private:
  struct Handle;
  std::string path_;
  std::unique_ptr<Handle> handle_;
  std::size_t done_ = 0;
};

/// True when a file starts with the two bytes of gzip. @throws InputError  when it cannot be opened
bool is_gzip(const std::string& path);

/// Size of a file, [bytes]. @throws InputError
std::size_t file_size(const std::string& path);

}  // namespace brim
