#pragma once

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>

#include "brim/core/error.h"

namespace brim {

/// A whole file in memory and a read position, for readers of mixed text and binary formats. Every failure is an
/// InputError that names the file and the item being read.
class FileCursor {
 public:
  /// @throws InputError  when the file is missing or cannot be read
  explicit FileCursor(const std::filesystem::path& path);

  [[noreturn]] void fail(const std::string& reason) const { throw InputError(fmt::format("{}: {}", name_, reason)); }

  std::size_t left() const { return data_.size() - at_; }
  std::size_t place() const { return at_; }
  void go_to(std::size_t place) { at_ = place; }

  /// Fails when fewer than count · bytes_each bytes are left: called before memory is allocated for a count from the
  /// file.
  void expect(std::size_t count, std::size_t bytes_each, const char* what) const {
    if (count > left() / bytes_each)
      fail(fmt::format("the file is truncated or damaged: {} {} cannot fit in the {} bytes left", count, what, left()));
  }

  /// The rest of the line, without its end; advances to the next line.
  std::string_view line() {
    const std::size_t end = std::min(data_.find('\n', at_), data_.size());
    std::string_view text(data_.data() + at_, end - at_);
    at_ = std::min(end + 1, data_.size());
    if (!text.empty() && text.back() == '\r') text.remove_suffix(1);
    return text;
  }

  /// The next word; empty at the end of the file.
  std::string_view word() {
    while (at_ < data_.size() && is_space(data_[at_])) ++at_;
    const std::size_t first = at_;
    while (at_ < data_.size() && !is_space(data_[at_])) ++at_;
    return {data_.data() + first, at_ - first};
  }

  /// The next word as a number.
  template <class T>
  T number(const char* what) {
    std::string_view w = word();
    if (w.empty()) fail(fmt::format("the file ends where {} should stand", what));
    if (w.front() == '+') w.remove_prefix(1);
    T value{};
    const auto [end, error] = std::from_chars(w.data(), w.data() + w.size(), value);
    if (error != std::errc() || end != w.data() + w.size()) fail(fmt::format("'{}' stands where {} should", w, what));
    return value;
  }

  /// The next bytes as a value, in the given byte order.
  template <class T>
  T binary(bool swapped, const char* what) {
    if (left() < sizeof(T)) fail(fmt::format("the file ends where {} should stand", what));
    char bytes[sizeof(T)];
    std::memcpy(bytes, data_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    if (swapped) std::reverse(bytes, bytes + sizeof(T));
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    return value;
  }

 private:
  static bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

  std::string name_, data_;
  std::size_t at_ = 0;
};

}  // namespace brim
