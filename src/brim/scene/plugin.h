#pragma once

#include <string>

namespace brim {

/// Loads a library with user-defined kinds of bodies (docs/bodies/your_own.md), available in scenes read from then on.
/// It uses the brim of the loading program, and must have been built with its compiler and version. Loading it again
/// does nothing.
/// @param path  a name without a slash is a file in the working folder
/// @throws InputError  "path: why": a library that cannot be loaded, or adds no kind
/// Tests: tests/scene/plugin_test.cpp
void load_plugin(const std::string& path);

}  // namespace brim
