#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace brim {

/// The allowed word that people mean by another one of the field ("hinge" for "revolute"); "" where there is none.
std::string meant_word(std::string_view given, const std::vector<std::string>& allowed);

/// A key that is right elsewhere.
struct RightPlace {
  std::string key;      ///< the allowed key under which it belongs, "" where there is none
  std::string message;  ///< where it belongs
};

/// Where a key of a body belongs that people write beside the others.
/// @param allowed  keys where it was given  Tests: tests/scene/common_words_test.cpp
RightPlace right_place(std::string_view given, const std::vector<std::string>& allowed);

}  // namespace brim
