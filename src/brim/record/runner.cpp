#include "brim/record/runner.h"

#include <algorithm>
#include <chrono>
#include <deque>
#include <filesystem>
#include <limits>
#include <optional>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/core/stop.h"
#include "brim/record/folder_lock.h"
#include "brim/record/h5.h"
#include "brim/record/run_folder.h"
#include "brim/record/run_layout.h"
#include "brim/record/scene_change.h"
#include "brim/record/sensor_csv.h"
#include "brim/record/sensor_record.h"
#include "brim/record/upgrade_run.h"
#include "brim/world/levels.h"
#include "brim/world/report_fields.h"
#include "brim/world/sense/sensors.h"

namespace brim {

namespace {

using Clock = std::chrono::steady_clock;

double since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }

/// Step rate over the last few seconds.
class Rate {
 public:
  double add(double wall, int steps) {
    steps_ += steps;
    if (wall - marks_.back().wall > 0.1) marks_.push_back({wall, steps_});
    while (marks_.size() > 2 && wall - marks_.front().wall > 10.0) marks_.pop_front();
    const double span = wall - marks_.front().wall;
    return span > 0.0 ? static_cast<double>(steps_ - marks_.front().steps) / span : 0.0;
  }

 private:
  struct Mark {
    double wall;
    std::int64_t steps;
  };
  std::deque<Mark> marks_ = {{0.0, 0}};
  std::int64_t steps_ = 0;
};

/// True for the folder of a run whose process was killed before its first frame was on disk.
bool never_began(const std::string& folder) {
  const std::string file = (std::filesystem::path(folder) / "run.h5").string();
  if (!std::filesystem::is_regular_file(file)) return false;
  return h5::never_flushed(file) || RunReader(folder).frames() == 0;
}

/// Takes the files of a new run away again, unless it comes to its first frame.
class NewRun {
 public:
  /// @param folder  locked by this process: what lies in it is nobody else's
  /// @param made    it was not there before
  NewRun(std::string folder, bool made) : folder_(std::move(folder)), made_(made) {}
  void keep() { folder_.clear(); }
  ~NewRun() {
    std::error_code error;
    if (!folder_.empty()) remove_run_files(folder_);
    if (!folder_.empty() && made_) std::filesystem::remove(folder_, error);  // only when nothing else is in it
  }

 private:
  std::string folder_;
  bool made_;
};

/// Gives a frame the levels of detail that it had in another run.
void take_levels(const RunReader& leader, std::int64_t frame, World& world) {
  if (frame >= leader.frames())
    throw InputError(
        fmt::format("{}: has {} frames, and levels are wanted for frame {}", leader.path(), leader.frames(), frame));
  const std::vector<int> levels = levels_in(leader.state(frame));
  if (levels.empty())
    throw InputError(fmt::format("{}: holds no levels of detail; its scene has no \"levels\"", leader.path()));
  follow_levels(world, levels);
}

/// Hands the readings of recorded frames back to the sensors of a world, one frame after another.
class RecordedReadings {
 public:
  RecordedReadings(const RunReader& run, World& world) : sensors_(find_sensors(world)) {
    if (sensors_ == nullptr) return;
    const SensorRecord record(run);
    for (std::size_t i = 0; i < sensors_->size(); ++i) {
      const auto at = std::ranges::find(record.sensors(), sensors_->sensor(i).model().name, &RecordedSensor::name);
      values_.push_back(at == record.sensors().end()
                            ? std::vector<double>{}
                            : record.values(static_cast<std::size_t>(at - record.sensors().begin())));
    }
  }
  void restore(std::int64_t frame) {
    for (std::size_t i = 0; i < values_.size(); ++i) {
      const std::size_t n = sensors_->sensor(i).channels().size(), first = static_cast<std::size_t>(frame) * n;
      // A sensor that the run does not know has read nothing.
      std::vector<double> row(n, std::numeric_limits<double>::quiet_NaN());
      if (first + n <= values_[i].size())
        std::copy_n(values_[i].begin() + static_cast<std::ptrdiff_t>(first), n, row.begin());
      sensors_->restore_frame(i, row);
    }
  }

 private:
  Sensors* sensors_;
  std::vector<std::vector<double>> values_;  ///< of all frames, per sensor
};

/// The steps of one frame, joined.
StepReport step_frame(World& world, int steps, int& taken, const std::function<void(World&)>& before_step) {
  if (Sensors* sensors = find_sensors(world)) sensors->begin_frame();
  StepReport frame;
  for (taken = 0; taken < steps && frame.ok; ++taken) {
    if (before_step) before_step(world);
    StepReport step = world.step();
    if (taken == 0)
      frame = std::move(step);
    else
      accumulate(frame, std::move(step));
  }
  return frame;
}

/// A run in progress. Each step of record_run is a method; they are called in the order of their declaration.
class Recording {
 public:
  using Progress = std::function<bool(const RunProgress&)>;

  Recording(World& world, const RunPlan& plan, const Progress& progress)
      : world_(world),
        plan_(plan),
        progress_(progress),
        measures_(world, plan.expect, static_cast<double>(plan.scene_frames) * plan.info.frame_time),
        start_(Clock::now()) {}

  /// Locks the folder, goes through the frames of a run that is resumed, and opens the file.
  void open() {
    if (plan_.resume && std::filesystem::is_directory(plan_.folder)) {
      lock_ = FolderLock(plan_.folder);
      result_.started_over = never_began(plan_.folder);
    }
    resumes_ = plan_.resume && !result_.started_over;
    if (resumes_)
      replay();
    else if (!plan_.folder.empty() && !plan_.resume)
      make_folder();
    if (plan_.folder.empty()) return;
    if (resumes_) {
      if (plan_.edit) replace_scene(plan_.folder, plan_.info.scene_text, frame_);
      writer_.emplace(plan_.folder, world_, frame_);
    } else {
      writer_.emplace(plan_.folder, world_, plan_.info);
    }
  }

  /// Records the world as built, unless a run is resumed.
  void first_frame() {
    if (!resumes_) {
      const StepReport present = world_.present();
      measures_.add(world_, present, 0);
      result_.totals.add(present, 0);
      if (writer_) writer_->add(world_, present, 0, measures_.samples());
    }
    if (writer_ && plan_.started) {
      writer_->flush();
      plan_.started();
    }
  }

  /// Ends what counts as building.
  void begin_steps() {
    if (!plan_.levels.empty()) leader_.emplace(plan_.levels);
    build_and_start_ = since(start_);
    stepping_ = Clock::now();
    began_at_ = frame_;
  }

  /// True until all frames are recorded.
  bool has_more() const { return frame_ < plan_.frames; }

  /// Computes and records the next frame. @return false when the run ends here
  bool run_frame() {
    if (leader_) take_levels(*leader_, frame_ + 1, world_);
    int taken = 0;
    StepReport report;
    if (!step(report, taken)) return false;
    // Recording a frame ends after its report is written: its time counts with the next.
    report.seconds[static_cast<std::size_t>(Phase::Record)] += record_seconds_;
    const Clock::time_point recording = Clock::now();
    ++frame_;
    if (fresh_) fresh_->keep();
    measures_.add(world_, report, taken);
    result_.totals.add(report, taken);
    if (writer_) writer_->add(world_, report, taken, measures_.samples());
    record_seconds_ = since(recording);
    const bool go_on = tell(report, taken);
    if (!report.ok) {
      result_.end = RunEnd::Failed;
      return false;
    }
    if (!go_on && has_more()) {
      result_.end = RunEnd::Interrupted;
      return false;
    }
    return true;
  }

  /// Closes the file, and writes what is made of all frames.
  RunResult close() {
    result_.totals.seconds[static_cast<std::size_t>(Phase::Record)] += record_seconds_;
    result_.findings = measures_.findings();
    if (Sensors* sensors = find_sensors(world_)) sensors->end_frames();
    if (writer_) {
      writer_->flush();
      writer_.reset();  // the tables are made of what the file holds
      write_sensor_csv(RunReader(plan_.folder), plan_.folder);
      write_summary();
    }
    return std::move(result_);
  }

 private:
  void make_folder() {
    check_run_folder(plan_.folder, plan_.force);
    std::error_code error;
    const bool made = !std::filesystem::exists(plan_.folder, error);
    std::filesystem::create_directories(plan_.folder, error);
    if (error) throw InputError(fmt::format("{}: the folder cannot be made: {}", plan_.folder, error.message()));
    lock_ = FolderLock(plan_.folder);
    fresh_.emplace(plan_.folder, made);
  }

  /// Checks that the run in the folder can be continued. @return true when an older version wrote it
  bool check_found() const {
    const RunReader found(plan_.folder);
    check_same_world(found, world_);
    if (!plan_.edit) need_same_scene(plan_.folder, plan_.info.scene_text);
    return found.format_version() != run_layout::kVersion && found.frames() > 0;
  }

  /// Takes over the recorded frames: their measures, totals and readings, and the state of the last.
  void replay() {
    if (check_found()) upgrade_run(plan_.folder, world_);
    const RunReader old(plan_.folder);
    frame_ = old.frames() - 1;
    RecordedReadings readings(old, world_);
    // A failed frame is a report, not a state to go on from twice; its state is that before the failure.
    for (std::int64_t f = 0; f <= frame_; ++f) {
      const StepReport report = old.report(f);
      if (measures_.needs_state()) world_.set_state(old.state(f));
      readings.restore(f);
      measures_.restore(world_, report, old.steps(f), report.warnings.size(), old.samples(f));
      result_.totals.add(report, old.steps(f));
    }
    world_.set_state(old.state(frame_));
    readings.restore(frame_);
  }

  /// The steps of the next frame. @return false when they were stopped, or refused after the first frame
  bool step(StepReport& report, int& taken) {
    const State before = plan_.stop ? world_.state() : State{};
    try {
      const StopScope scope(plan_.stop);
      check_stop();
      report = step_frame(world_, plan_.info.steps_per_frame, taken, plan_.before_step);
      return true;
    } catch (const Stopped&) {
      world_.set_state(before);
      if (fresh_) fresh_->keep();
      result_.end = RunEnd::Interrupted;
    } catch (const InputError& e) {
      const std::string why = (plan_.scene_file.empty() ? "" : plan_.scene_file + ": ") + e.what();
      if (frame_ == began_at_) throw InputError(why);
      result_.end = RunEnd::Failed;
      result_.refused = why;
      result_.totals.warn({world_.state().time, "refused", result_.refused});
    }
    return false;
  }

  /// Tells of the progress. @return false when the run is to end
  bool tell(const StepReport& report, int taken) {
    const double steps_per_second = rate_.add(since(stepping_), taken);
    const double left = static_cast<double>(plan_.frames - frame_) * plan_.info.steps_per_frame;
    return !progress_ || progress_({frame_, plan_.frames, world_.state().time, steps_per_second,
                                    steps_per_second > 0.0 ? left / steps_per_second : 0.0, &report});
  }

  void write_summary() const {
    RunFacts facts;
    facts.scene_name = plan_.info.scene_name;
    facts.scene_file = plan_.scene_file;
    facts.threads = thread_count();
    facts.frames_wanted = plan_.frames;
    facts.frame_time = plan_.info.frame_time;
    facts.wall = since(stepping_);
    facts.build_wall = plan_.build_wall + build_and_start_;
    facts.end = result_.end;
    write_whole((std::filesystem::path(plan_.folder) / "summary.json").string(),
                summary_text(world_, result_.totals, facts, result_.findings));
  }

  World& world_;
  const RunPlan& plan_;
  const Progress& progress_;
  RunResult result_;
  Measures measures_;
  FolderLock lock_;              // held until all files are closed, or taken away again
  std::optional<NewRun> fresh_;  // outlives the writer
  std::optional<RunWriter> writer_;
  std::optional<RunReader> leader_;
  bool resumes_ = false;
  std::int64_t frame_ = 0;     ///< last recorded
  std::int64_t began_at_ = 0;  ///< frame before the first step
  Clock::time_point start_, stepping_;
  double build_and_start_ = 0.0;  ///< [s]
  double record_seconds_ = 0.0;   ///< [s] of the last frame, not yet in a report
  Rate rate_;
};

}  // namespace

bool RunResult::ok() const {
  return end == RunEnd::Completed &&
         std::all_of(findings.begin(), findings.end(), [](const ExpectationResult& f) { return f.as_expected(); });
}

RunResult record_run(World& world, const RunPlan& plan, const std::function<bool(const RunProgress&)>& progress) {
  Recording recording(world, plan, progress);
  recording.open();
  recording.first_frame();
  recording.begin_steps();
  while (recording.has_more() && recording.run_frame()) {
  }
  return recording.close();
}

}  // namespace brim
