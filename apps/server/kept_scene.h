#pragma once

#include <string>
#include <vector>

#include "brim/record/run_reader.h"

namespace brim::viewer {

/// The scene that a run keeps.
struct KeptScene {
  std::string text;
  std::string file;  ///< it was read from, or scene.json of the folder: relative paths in it start from its folder
};

/// Reads it. @throws InputError  when the run's folder has none  Tests: tests/apps/cli_test.cpp
KeptScene kept_scene(const RunReader& run);

/// The same of a folder whose run.h5 may have no frame yet.
KeptScene kept_scene(const std::string& folder);

/// Why no program can build the world of a kept scene: bodies of it are written in Python. Empty: none is.
std::string python_bodies(const KeptScene& kept);

}  // namespace brim::viewer
