#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <string>

#include "brim/record/h5.h"

/// Shared parts of the files of h5.h: the library's types, and checks with one error message.
namespace brim::h5 {

/// Type of elements in memory.
Id native(Type t);
/// Type in the file: little-endian on any machine.
Id stored(Type t);
/// Type of strings of a given length, padded with zeros.
Handle text_type(std::size_t length);

/// Disables the library's own error output; errors are reported by brim. Thread-safe builds of HDF5 store the setting
/// per thread.
void hush();

/// Deflate compresses by at most 1032 : 1 (zlib's documentation): a larger shape cannot be stored in the file.
constexpr std::uint64_t kMostDeflation = 1100;
/// [bytes] allowance added to that bound, for small shapes.
constexpr std::uint64_t kSmallBytes = 1 << 20;

constexpr const char* kNotWritten = "cannot be written; is the disk full?";

/// Returns the result of a library call. @throws InputError  "path: what", when it signals a failure
template <class T>
T need(T result, const std::string& path, const char* what) {
  if (result < 0) throw InputError(fmt::format("{}: {}", path, what));
  return result;
}

/// Rejects data sets that store fewer bytes than their elements need: HDF5 1.10 assumes a full chunk or compact data
/// set whatever its stored length, and would read beyond its end. Not detected: wrong chunk lengths with a correct sum,
/// and the unpacked size of compressed chunks.
void need_whole_storage(Id set, const std::string& path);

}  // namespace brim::h5
