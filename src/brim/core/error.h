#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <string>
#include <string_view>

namespace brim {

/// Invalid input from the user, thrown where it enters (scene, files, public parameters).
/// The message names the file, the place in it, the value found and the values allowed.
class InputError : public std::runtime_error {
 public:
  explicit InputError(const std::string& message) : std::runtime_error(message) {}
};

/// A violated invariant between two pieces of brim's own code: a bug to report, never the user's fault.
class ProgrammingError : public std::logic_error {
 public:
  explicit ProgrammingError(const std::string& message) : std::logic_error(message) {}
};

namespace detail {
template <class A, class B>
[[noreturn]] void check_failed(const char* file, int line, const char* text, const A& a, const B& b) {
  throw ProgrammingError(fmt::format("{}:{}: check failed: {} (left {}, right {})", file, line, text, a, b));
}
}  // namespace detail

}  // namespace brim

/// Check that is always compiled in: compares two values and throws ProgrammingError with both when it fails.
/// Usage: BRIM_CHECK(a, ==, b).
#define BRIM_CHECK(a, op, b)                                                                                          \
  do {                                                                                                                \
    const auto& brim_a_ = (a);                                                                                        \
    const auto& brim_b_ = (b);                                                                                        \
    if (!(brim_a_ op brim_b_)) ::brim::detail::check_failed(__FILE__, __LINE__, #a " " #op " " #b, brim_a_, brim_b_); \
  } while (false)
