#pragma once

#include <string>

namespace brim {

/// Loads a library with kinds of bodies of one's own (docs/bodies/your_own.md): scenes that are read from then on know
/// them. It takes brim from the program that loads it, and must have been built with its compiler and version. Loading
/// it again does nothing.
/// @param path  a name without a slash is a file of the working folder
/// @throws InputError  "path: why": what cannot be loaded, and a library that adds no kind
/// Tests: tests/scene/plugin_test.cpp
void load_plugin(const std::string& path);

}  // namespace brim
