#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>

#include "brim/record/run_reader.h"
#include "server/rebuilt_world.h"
#include "server/run_source.h"

namespace brim::viewer {

/// A run folder, finished or growing. The file is opened anew when it has changed, since an open reader sees the file
/// as it was; one lock keeps HDF5, which is not made for threads, to one caller at a time.
/// Tests: tests/server/recorded_run_test.cpp
class RecordedRun : public RunSource {
 public:
  /// @param path  a run folder or its run.h5
  /// @throws InputError  when there is no run there
  explicit RecordedRun(const std::string& path);

  Progress progress() override;
  nlohmann::json info() override;
  std::string topology(int body) override;
  std::string frame(std::int64_t frame) override;
  std::string slice(std::int64_t frame, const SliceRequest& request) override;
  std::string stress(std::int64_t frame) override;
  std::string series(std::int64_t from) override;

  /// Frames per second at which the run plays in its own time, at most 60.
  double frame_rate();

 private:
  /// Opens the file if it is not open or has changed. @throws InputError  when it cannot be read
  void refresh();
  bool fixed(std::size_t body) const;  ///< neither moved by the simulation nor animated
  /// Fills in whether more frames are to be expected.
  void find_end(Progress& progress) const;
  bool writer_gone() const;
  /// Calls show(world) with the world of a frame, one call at a time; the server has a thread left for all else.
  /// @throws Busy
  std::string with_world(std::int64_t frame, const std::function<std::string(const World&)>& show);

  std::filesystem::path folder_, file_;
  std::mutex mutex_;
  std::unique_ptr<RunReader> reader_;
  std::filesystem::file_time_type seen_{};  ///< when the file as it is open was written
  Progress progress_;                       ///< last known
  std::vector<Warning> warnings_;           ///< of the frames read so far
  std::int64_t warnings_read_ = 0;          ///< frames whose warnings are in the list
  ProcessMark writer_;                      ///< of the file as it is open: another one may have begun it anew
  bool world_stale_ = false;                ///< world_ is of a run that has been replaced or gone on with since
  std::mutex world_mutex_;                  ///< taken before mutex_ where both are
  std::atomic<int> asked_ = 0;              ///< calls of with_world that run or wait
  std::unique_ptr<RebuiltWorld> world_;     ///< made when it is first asked for
};

}  // namespace brim::viewer
