#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <string>

#include "brim/record/h5.h"

/// What the files of h5.h share: the library's types, and checks that end in one message.
namespace brim::h5 {

/// Type of elements in memory.
Id native(Type t);
/// And in the file: little-endian, whatever the machine.
Id stored(Type t);
/// Of strings of that length, padded with zeros.
Handle text_type(std::size_t length);

/// Keeps the library from printing its error stack; we say what went wrong ourselves. Builds of HDF5 for threads keep
/// the setting for each thread apart.
void hush();

/// Deflate packs at most 1032 : 1 (zlib's documentation): what a shape says beyond that is not in the file.
constexpr std::uint64_t kMostDeflation = 1100;
/// [bytes] that any shape may say.
constexpr std::uint64_t kSmallBytes = 1 << 20;

constexpr const char* kNotWritten = "cannot be written; is the disk full?";

/// Hands on what a call of the library returned. @throws InputError  "path: what", where that tells of a failure
template <class T>
T need(T result, const std::string& path, const char* what) {
  if (result < 0) throw InputError(fmt::format("{}: {}", path, what));
  return result;
}

/// Refuses data sets that store fewer bytes than their elements need: HDF5 1.10 takes a chunk or a compact data set for
/// whole whatever its length in the file says, and would read beyond its end. Chunks whose lengths are wrong but right
/// together are not seen, nor what packed chunks unpack to.
void need_whole_storage(Id set, const std::string& path);

}  // namespace brim::h5
