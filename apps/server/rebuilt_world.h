#pragma once

#include <memory>
#include <string>
#include <vector>

#include "brim/record/run_reader.h"
#include "brim/world/world.h"

namespace brim::viewer {

/// Kinds of the run's bodies that are not known here: those of a plugin that is not loaded, or of a Python program.
std::vector<std::string> foreign_kinds(const RunReader& run);

/// The world of a recorded run, built anew from the scene that the run keeps, to ask for what is not recorded: the
/// densities of its bodies. Tests: tests/server/density_slice_test.cpp
class RebuiltWorld {
 public:
  /// Builds it. @throws InputError  when the run's folder has no scene, or what it builds is not the recorded world
  explicit RebuiltWorld(const RunReader& run);

  /// The world in the state of a frame. @param run  as it is open now; the same run as at the start
  const World& at(const RunReader& run, std::int64_t frame);

 private:
  std::unique_ptr<World> world_;
  std::int64_t frame_ = -1;  ///< whose state it is in
};

}  // namespace brim::viewer
