#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace brim {

/// Throws unless a path is a regular file: reading a pipe may block, a device may be endless.
/// @throws InputError
void need_regular_file(const std::string& path);

/// All bytes of a regular file, or nothing when there is none (also when the path is a pipe or a device).
/// @throws InputError  for a file of more than `most` bytes
std::optional<std::string> read_regular_file(const std::string& path, std::uint64_t most = std::uint64_t{1} << 30);

}  // namespace brim
