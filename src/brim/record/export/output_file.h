#pragma once

#include <bit>
#include <filesystem>
#include <fstream>
#include <span>
#include <string_view>

namespace brim::exporting {

// Numbers are written in memory layout; every format here is little-endian.
static_assert(std::endian::native == std::endian::little);

/// A sequentially written file; every failure is an InputError that names it.
class OutputFile {
 public:
  explicit OutputFile(const std::filesystem::path& path);
  void write(std::string_view text) { write(text.data(), text.size()); }
  void write(const void* data, std::size_t bytes);
  template <class T>
  void write_number(T value) {
    write(&value, sizeof value);
  }
  template <class T>
  void write_array(std::span<const T> values) {
    write(values.data(), values.size_bytes());
  }
  /// Bytes written so far.
  std::uint64_t size() const { return size_; }
  /// Overwrites bytes at an earlier position, then continues at the end.
  void patch(std::uint64_t at, const void* data, std::size_t bytes);
  /// Must be called last. @throws InputError  when not everything has reached the disk
  void close();

 private:
  [[noreturn]] void fail() const;
  std::filesystem::path path_;
  std::ofstream file_;
  std::uint64_t size_ = 0;
};

}  // namespace brim::exporting
