#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace brim {

/// Throws unless a path is that of a regular file: a pipe would be waited for, a device may have no end.
/// @throws InputError
void need_regular_file(const std::string& path);

/// All bytes of a regular file, or nothing where there is none (also where a pipe or a device has its name).
/// @throws InputError  for a file of more than `most` bytes
std::optional<std::string> read_regular_file(const std::string& path, std::uint64_t most = std::uint64_t{1} << 30);

}  // namespace brim
