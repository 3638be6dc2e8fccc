#pragma once

#include <string>
#include <string_view>

namespace brim {

/// Text made safe for a terminal: control characters (C0, DEL, C1) as \n, \t, \r or \u00xx, invalid UTF-8 bytes as
/// \xNN. Tests: tests/core/printable_test.cpp
std::string printable(std::string_view text);

}  // namespace brim
