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

}  // namespace

bool RunResult::ok() const {
  return end == RunEnd::Completed &&
         std::all_of(findings.begin(), findings.end(), [](const ExpectationResult& f) { return f.as_expected(); });
}

RunResult record_run(World& world, const RunPlan& plan, const std::function<bool(const RunProgress&)>& progress) {
  RunResult result;
  Measures measures(world, plan.expect, static_cast<double>(plan.scene_frames) * plan.info.frame_time);
  FolderLock lock;              // held until all files are closed, or taken away again
  std::optional<NewRun> fresh;  // outlives the writer
  std::optional<RunWriter> writer;
  std::int64_t frame = 0;
  const Clock::time_point start = Clock::now();

  if (plan.resume && std::filesystem::is_directory(plan.folder)) {
    lock = FolderLock(plan.folder);
    result.started_over = never_began(plan.folder);
  }
  const bool resume = plan.resume && !result.started_over;
  if (resume) {
    bool older = false;
    {
      const RunReader found(plan.folder);
      check_same_world(found, world);
      if (!plan.edit) need_same_scene(plan.folder, plan.info.scene_text);
      older = found.format_version() != run_layout::kVersion && found.frames() > 0;
    }
    if (older) upgrade_run(plan.folder, world);
    const RunReader old(plan.folder);
    frame = old.frames() - 1;
    RecordedReadings readings(old, world);
    // A failed frame is a report, not a state to go on from twice; its state is that before the failure.
    for (std::int64_t f = 0; f <= frame; ++f) {
      const StepReport report = old.report(f);
      if (measures.needs_state()) world.set_state(old.state(f));
      readings.restore(f);
      measures.restore(world, report, old.steps(f), report.warnings.size(), old.samples(f));
      result.totals.add(report, old.steps(f));
    }
    world.set_state(old.state(frame));
    readings.restore(frame);
  } else if (!plan.folder.empty() && !plan.resume) {
    check_run_folder(plan.folder, plan.force);
    std::error_code error;
    const bool made = !std::filesystem::exists(plan.folder, error);
    std::filesystem::create_directories(plan.folder, error);
    if (error) throw InputError(fmt::format("{}: the folder cannot be made: {}", plan.folder, error.message()));
    lock = FolderLock(plan.folder);
    fresh.emplace(plan.folder, made);
  }
  if (!plan.folder.empty()) {
    if (resume) {
      if (plan.edit) replace_scene(plan.folder, plan.info.scene_text, frame);
      writer.emplace(plan.folder, world, frame);
    } else
      writer.emplace(plan.folder, world, plan.info);
  }
  if (!resume) {
    const StepReport nothing;
    measures.add(world, nothing, 0);
    result.totals.add(nothing, 0);
    if (writer) writer->add(world, nothing, 0, measures.samples());
  }

  if (writer && plan.started) {
    writer->flush();
    plan.started();
  }
  std::optional<RunReader> leader;
  if (!plan.levels.empty()) leader.emplace(plan.levels);
  Rate rate;
  double record_seconds = 0.0;
  const double build_and_start = since(start);
  const Clock::time_point stepping = Clock::now();
  const std::int64_t first_frame = frame;
  while (frame < plan.frames) {
    int taken = 0;
    if (leader) take_levels(*leader, frame + 1, world);
    StepReport report;
    const State before = plan.stop ? world.state() : State{};
    try {
      const StopScope scope(plan.stop);
      check_stop();
      report = step_frame(world, plan.info.steps_per_frame, taken, plan.before_step);
    } catch (const Stopped&) {
      world.set_state(before);
      if (fresh) fresh->keep();
      result.end = RunEnd::Interrupted;
      break;
    } catch (const InputError& e) {
      const std::string why = (plan.scene_file.empty() ? "" : plan.scene_file + ": ") + e.what();
      if (frame == first_frame) throw InputError(why);
      result.end = RunEnd::Failed;
      result.refused = why;
      result.totals.warn({world.state().time, "refused", result.refused});
      break;
    }
    // Recording a frame ends after its report is written: its time counts with the next.
    report.seconds[static_cast<std::size_t>(Phase::Record)] += record_seconds;
    const Clock::time_point recording = Clock::now();
    ++frame;
    if (fresh) fresh->keep();
    measures.add(world, report, taken);
    result.totals.add(report, taken);
    if (writer) writer->add(world, report, taken, measures.samples());
    record_seconds = since(recording);
    const double steps_per_second = rate.add(since(stepping), taken);
    const double left = static_cast<double>(plan.frames - frame) * plan.info.steps_per_frame;
    const bool go_on = !progress || progress({frame, plan.frames, world.state().time, steps_per_second,
                                              steps_per_second > 0.0 ? left / steps_per_second : 0.0, &report});
    if (!report.ok) {
      result.end = RunEnd::Failed;
      break;
    }
    if (!go_on && frame < plan.frames) {
      result.end = RunEnd::Interrupted;
      break;
    }
  }
  result.totals.seconds[static_cast<std::size_t>(Phase::Record)] += record_seconds;
  result.findings = measures.findings();
  if (Sensors* sensors = find_sensors(world)) sensors->end_frames();
  if (writer) {
    writer->flush();
    writer.reset();  // the tables are made of what the file holds
    write_sensor_csv(RunReader(plan.folder), plan.folder);
    RunFacts facts;
    facts.scene_name = plan.info.scene_name;
    facts.scene_file = plan.scene_file;
    facts.threads = thread_count();
    facts.frames_wanted = plan.frames;
    facts.frame_time = plan.info.frame_time;
    facts.wall = since(stepping);
    facts.build_wall = plan.build_wall + build_and_start;
    facts.end = result.end;
    write_whole((std::filesystem::path(plan.folder) / "summary.json").string(),
                summary_text(world, result.totals, facts, result.findings));
  }
  return result;
}

}  // namespace brim
