#include "recorder.h"

#include <chrono>
#include <filesystem>

#include "brim/core/parallel.h"
#include "brim/record/run_folder.h"
#include "brim/record/run_reader.h"
#include "brim/record/sensor_csv.h"
#include "brim/world/sense/sensors.h"

namespace brim::python {

namespace {

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

}  // namespace

Recorder::Recorder(Session& session, const std::string& folder, const std::string& name, std::int64_t frames,
                   int steps_per_frame, const std::string& scene_text, const std::string& scene_path, bool force)
    : folder_(folder), frames_(frames), start_(now()) {
  World& world = session.world();
  info_ = {name, scene_text, world.options().time_step * steps_per_frame, steps_per_frame, scene_path};
  check_run_folder(folder, force);
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw InputError(fmt::format("{}: the folder cannot be made: {}", folder, error.message()));
  lock_ = FolderLock(folder);
  measures_.emplace(world, session.expect, static_cast<double>(frames) * info_.frame_time);
  writer_.emplace(folder, world, info_);
  const StepReport nothing;
  measures_->add(world, nothing, 0);
  totals_.add(nothing, 0);
  writer_->add(world, nothing, 0, measures_->samples());
  if (Sensors* sensors = find_sensors(world)) sensors->begin_frame();
}

Recorder::~Recorder() = default;

void Recorder::add(Session& session, int steps) {
  if (!writer_) throw InputError(folder_ + ": the recording has ended");
  World& world = session.world();
  if (static_cast<std::size_t>(world.body_count()) != measures_->samples().size())
    throw InputError(
        fmt::format("{}: records {} bodies, and the world has {} now; add bodies before a recording begins", folder_,
                    measures_->samples().size(), world.body_count()));
  measures_->add(world, session.report(), steps);
  totals_.add(session.report(), steps);
  writer_->add(world, session.report(), steps, measures_->samples());
  if (Sensors* sensors = find_sensors(world)) sensors->begin_frame();
}

py::list Recorder::finish(Session& session, const std::string& end) {
  py::list list;
  if (!writer_) return list;
  World& world = session.world();
  if (Sensors* sensors = find_sensors(world)) sensors->end_frames();
  const std::vector<ExpectationResult> findings = measures_->findings();
  writer_->flush();
  writer_.reset();  // the tables are made of what the file holds
  write_sensor_csv(RunReader(folder_), folder_);
  RunFacts facts;
  facts.scene_name = info_.scene_name;
  facts.scene_file = info_.scene_path;
  facts.threads = thread_count();
  facts.frames_wanted = frames_;
  facts.frame_time = info_.frame_time;
  facts.wall = now() - start_;
  facts.end = end == "completed" ? RunEnd::Completed : end == "failed" ? RunEnd::Failed : RunEnd::Interrupted;
  write_whole((std::filesystem::path(folder_) / "summary.json").string(),
              summary_text(world, totals_, facts, findings));
  lock_ = FolderLock();
  for (const ExpectationResult& f : findings) {
    py::dict d;
    d["metric"] = f.expectation.metric;
    d["body"] = f.body.empty() ? f.expectation.body : f.body;
    d["value"] = f.value;
    d["reached"] = f.reached;
    d["ok"] = f.ok;
    d["known_miss"] = f.expectation.known_miss;
    list.append(d);
  }
  return list;
}

}  // namespace brim::python
