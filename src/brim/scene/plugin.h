#pragma once

#include <string>

#include "brim/core/error.h"

namespace brim {

/// Loads a library with user-defined kinds of bodies (docs/bodies/your_own.md), available in scenes read from then on.
/// It uses the brim of the loading program, and must have been built with its compiler and version. Loading it again
/// does nothing.
/// @param path  a name without a slash is a file in the working folder
/// @throws InputError  "path: why": a library that cannot be loaded, adds no kind, adds one whose name is taken, or was
///                     built with other headers of brim
/// Tests: tests/scene/plugin_test.cpp
void load_plugin(const std::string& path);

/// Keeps an error of add_body_kind for load_plugin to throw, since no exception may cross the system's loader.
/// @return false: no plugin is being loaded
bool keep_plugin_error(const InputError& error);

}  // namespace brim
