#pragma once

#include <string>
#include <string_view>

namespace brim {

/// Text that a terminal shows and does not obey: control characters (C0, DEL, C1) as \n, \t, \r or \u00xx, bytes that
/// are no UTF-8 as \xNN. Tests: tests/core/printable_test.cpp
std::string printable(std::string_view text);

}  // namespace brim
