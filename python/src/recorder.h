#pragma once

#include <optional>
#include <string>

#include "brim/record/folder_lock.h"
#include "brim/record/run_writer.h"
#include "brim/record/summary.h"
#include "brim/world/measures.h"
#include "session.h"

namespace brim::python {

/// Records the frames of a session into a run folder, as `brim run` does: run.h5, scene.json and summary.json, with the
/// results of the scene's expectations. HDF5 serves one thread at a time: all functions need the interpreter's lock.
class Recorder {
 public:
  /// @param scene_text  for scene.json  @param scene_path  base of its relative paths
  /// @throws InputError  for unusable folders
  Recorder(Session& session, const std::string& folder, const std::string& name, std::int64_t frames,
           int steps_per_frame, const std::string& scene_text, const std::string& scene_path, bool force);
  ~Recorder();

  /// Records the frame of the session's report. @param steps  number of steps in it
  void add(Session& session, int steps);
  /// Writes everything out and the summary. @param end  "completed", "interrupted" or "failed"
  /// @return findings: one dict per expectation
  py::list finish(Session& session, const std::string& end);

 private:
  std::string folder_;
  RunInfo info_;
  std::int64_t frames_;
  FolderLock lock_;
  std::optional<RunWriter> writer_;
  std::optional<Measures> measures_;
  RunTotals totals_;
  double start_ = 0.0;  // [s]
};

}  // namespace brim::python
