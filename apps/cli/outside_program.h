#pragma once

#include <string>
#include <vector>

namespace brim::cli {

/// The first of some programs that is on the PATH or, with a slash, where it says; empty when none is.
std::string find_program(const std::vector<std::string>& names);

/// Runs a program to its end and returns its exit code. No shell sees the arguments.
/// @throws InputError  when it cannot be started
int run_program(const std::string& program, const std::vector<std::string>& arguments);

}  // namespace brim::cli
