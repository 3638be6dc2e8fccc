#pragma once

#include <functional>
#include <string>

#include "brim/record/run_reader.h"
#include "brim/record/run_writer.h"
#include "brim/record/summary.h"
#include "brim/world/measures.h"

namespace brim {

/// What to run and where to.
struct RunPlan {
  std::string folder;  ///< of the run; empty: nothing is recorded
  RunInfo info;
  std::string scene_file;
  std::int64_t frames = 0;        ///< recorded frames after the first, in all
  std::int64_t scene_frames = 0;  ///< of the scene: expectations without an end mean this one
  std::vector<Expectation> expect;
  double build_wall = 0.0;          ///< [s]
  bool force = false;               ///< replace an old run
  bool resume = false;              ///< go on with the run in the folder
  bool edit = false;                ///< where its scene was another one (same_scene): go on with the one given
  std::string levels{};             ///< a run whose levels of detail are taken, frame by frame; empty: they are chosen
  std::function<void()> started{};  ///< called once a first frame is on disk
  /// Called before each step, and may edit the world (docs/editing.md).
  std::function<void(World&)> before_step{};
  /// Asked between frames and often within a step, on its thread: true ends the run with the frames before it.
  std::function<bool()> stop{};
};

/// Where a run stands, after each frame.
struct RunProgress {
  std::int64_t frame = 0, frames = 0;
  double time = 0.0;              ///< [s] simulated
  double steps_per_second = 0.0;  ///< of wall time, of the last seconds
  double seconds_left = 0.0;      ///< [s] of wall time, estimated
  const StepReport* report = nullptr;
};

struct RunResult {
  RunEnd end = RunEnd::Completed;
  std::vector<ExpectationResult> findings;
  RunTotals totals;
  bool started_over = false;  ///< what was to be gone on with had no frame yet: the run was made from its start
  std::string refused{};      ///< why the last step could not be taken, as where memory_limit has no room for it
  bool ok() const;            ///< completed, and every finding as expected
};

/// Steps a world and records it. A run that is refused leaves nothing behind: what can be refused before its first step
/// is, before a folder is made, and what the first frame refuses takes a new folder with it. What is refused later ends
/// the run as one that failed, with the frames before it; a run that is stopped ends as one that was interrupted,
/// likewise.
/// @param world     as built; with plan.resume it is set to the last recorded state. A run that was stopped leaves it
/// in
///                  the state of the last frame
/// @param progress  called after each frame; false ends the run with all frames kept
/// @throws InputError  for folders that cannot be used and runs that do not fit
/// Tests: tests/record/run_test.cpp, tests/record/resume_test.cpp, tests/record/run_folder_test.cpp
RunResult record_run(World& world, const RunPlan& plan, const std::function<bool(const RunProgress&)>& progress);

}  // namespace brim
