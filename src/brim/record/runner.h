#pragma once

#include <functional>
#include <string>

#include "brim/record/run_reader.h"
#include "brim/record/run_writer.h"
#include "brim/record/summary.h"
#include "brim/world/measures.h"

namespace brim {

/// What to run, and where to record it.
struct RunPlan {
  std::string folder;  ///< of the run; empty: nothing is recorded
  RunInfo info;
  std::string scene_file;
  std::int64_t frames = 0;        ///< total number of recorded frames after the first
  std::int64_t scene_frames = 0;  ///< of the scene: default end of expectations
  std::vector<Expectation> expect;
  double build_wall = 0.0;          ///< [s]
  bool force = false;               ///< replace an old run
  bool resume = false;              ///< continue the run in the folder
  bool edit = false;                ///< with resume, if the scene has changed (same_scene): continue with the new one
  std::string levels{};             ///< run whose levels of detail are used, frame by frame; empty: they are chosen
  std::function<void()> started{};  ///< called once the first frame is on disk
  /// Called before each step, and may edit the world (docs/editing.md).
  std::function<void(World&)> before_step{};
  /// Polled between frames and often within a step, on its thread: true ends the run, keeping the frames before it.
  std::function<bool()> stop{};
};

/// Progress of a run, after each frame.
struct RunProgress {
  std::int64_t frame = 0, frames = 0;
  double time = 0.0;              ///< [s] simulated
  double steps_per_second = 0.0;  ///< per second of wall time, over the last seconds
  double seconds_left = 0.0;      ///< [s] of wall time, estimated
  const StepReport* report = nullptr;
};

struct RunResult {
  RunEnd end = RunEnd::Completed;
  std::vector<ExpectationResult> findings;
  RunTotals totals;
  bool started_over = false;  ///< the run to resume had no frame yet and was started anew
  std::string refused{};      ///< reason why the last step was refused, e.g. memory_limit
  bool ok() const;            ///< completed, and every expectation as expected
};

/// Steps a world and records it. A rejected run leaves nothing behind: everything that can be checked before the first
/// step is checked before the folder is created, and a failure in the first frame removes a new folder. A later failure
/// ends the run as failed, with the frames before it; a stopped run ends as interrupted, likewise.
/// @param world     as built; with plan.resume it is set to the last recorded state. A stopped run leaves it in the
///                  state of the last frame
/// @param progress  called after each frame; false ends the run with all frames kept
/// @throws InputError  for unusable folders and runs that do not match the world
/// Tests: tests/record/run_test.cpp, tests/record/resume_test.cpp, tests/record/run_folder_test.cpp
RunResult record_run(World& world, const RunPlan& plan, const std::function<bool(const RunProgress&)>& progress);

}  // namespace brim
