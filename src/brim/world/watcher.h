#pragma once

#include <vector>

#include "brim/world/step_report.h"

namespace brim {

class World;

/// Observer of every step, and of every sub-step with its contacts (World::watch). It changes nothing in the world;
/// calls come on the stepping thread, outside parallel loops.
/// Tests: tests/world/sense/sensors_test.cpp
class Watcher {
 public:
  virtual ~Watcher() = default;

  /// Before the first sub-step of a step.
  virtual void begin_step(const World& world) { (void)world; }
  /// Called when the contacts of a sub-step are known (World::contacts) and bodies have not moved yet: the state and
  /// the last update of the bodies belong to these contacts. Not called for a sub-step that failed.
  /// @param time, dt  [s] start and length of the sub-step
  virtual void substep(const World& world, double time, double dt) = 0;
  /// The world was given another state: readings of the last step do not belong to it.
  virtual void restored(const World& world) { (void)world; }
  /// The step has ended and bodies are at their new positions.
  virtual void end_step(const World& world, const StepReport& report) = 0;

  /// Reads and removes the watcher's part at the front of State::warm_start; empty if it was not watching. take and
  /// keep are also called together between steps: keep must write what take read.
  virtual void take(std::vector<double>& memory) { (void)memory; }
  /// Writes the watcher's state for the next step in front of the rest of memory.
  virtual void keep(const World& world, std::vector<double>& memory) const { (void)world, (void)memory; }
};

}  // namespace brim
