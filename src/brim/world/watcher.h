#pragma once

#include <vector>

#include "brim/world/step_report.h"

namespace brim {

class World;

/// What a world tells of every step, and of every sub-step with its contacts (World::watch). It reads and changes
/// nothing of the world; calls come on the thread that steps, outside parallel loops.
/// Tests: tests/world/sense/sensors_test.cpp
class Watcher {
 public:
  virtual ~Watcher() = default;

  /// Before the first sub-step of a step.
  virtual void begin_step(const World& world) { (void)world; }
  /// Contacts of a sub-step are known (World::contacts) and bodies have not moved yet: state and last update of the
  /// bodies are those in which these contacts are. Not called for a sub-step that failed.
  /// @param time, dt  [s] start and length of the sub-step
  virtual void substep(const World& world, double time, double dt) = 0;
  /// The world was given another state: what was read of the last step is not of this one.
  virtual void restored(const World& world) { (void)world; }
  /// The step has ended and bodies are where it left them.
  virtual void end_step(const World& world, const StepReport& report) = 0;

  /// Takes what State::warm_start holds of the watcher, in front of all else, and removes it there: nothing where it
  /// was not watching. Both are called together also between steps: what is kept follows from what was taken.
  virtual void take(std::vector<double>& memory) { (void)memory; }
  /// Puts what the next step goes on from in front of what memory holds.
  virtual void keep(const World& world, std::vector<double>& memory) const { (void)world, (void)memory; }
};

}  // namespace brim
