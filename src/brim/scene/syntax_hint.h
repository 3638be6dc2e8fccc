#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace brim {

/// What is wrong with commas and colons at a place where a JSON parser stopped, in the words of the person who wrote
/// it.
struct SyntaxHint {
  int line;  ///< where the comma is, or belongs
  std::string message;
};

/// @param text  up to and with the token that the parser did not expect
/// @param complaint  of the parser, "unexpected ...; expected ..."
/// Nothing where it is another mistake.  Tests: tests/scene/syntax_hint_test.cpp
std::optional<SyntaxHint> syntax_hint(std::string_view text, std::string_view complaint);

}  // namespace brim
