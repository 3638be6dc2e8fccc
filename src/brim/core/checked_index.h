#pragma once

#include <cstddef>

#include "brim/core/error.h"

namespace brim {

/// The number that a user gives of one of n things, as an index.
/// The first is 0.
/// @param function, thing  of the message: "q: body 9 is not there; there are 2"
/// @throws InputError  unless 0 <= number < n
/// Tests: tests/world/given_values_test.cpp
inline std::size_t checked_index(int number, std::size_t n, const char* function, const char* thing) {
  if (number >= 0 && static_cast<std::size_t>(number) < n) return static_cast<std::size_t>(number);
  throw InputError(fmt::format("{}: {} {} is not there; there are {}", function, thing, number, n));
}

}  // namespace brim
