#include "brim/record/run_writer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>

#include "brim/record/column.h"
#include "brim/record/frame_display.h"
#include "brim/record/frame_lists.h"
#include "brim/record/frame_sensors.h"
#include "brim/record/h5.h"
#include "brim/record/process_mark.h"
#include "brim/record/run_folder.h"
#include "brim/record/run_layout.h"
#include "brim/record/run_tables.h"
#include "brim/record/xdmf.h"
#include "brim/world/report_fields.h"

namespace brim {

namespace fs = std::filesystem;
using h5::Type;
using Clock = std::chrono::steady_clock;

namespace {

constexpr std::uint64_t kRows = 256;  // of numbers in a chunk
constexpr double kFlushSeconds = 1.0;
constexpr double kFlushShare = 0.02;  // of the time, at most, when frames are fast
constexpr double kXdmfSeconds = 10.0;
constexpr double kXdmfShare = 0.01;
constexpr std::int64_t kXdmfGrids = 4096;     // in one piece of text
constexpr std::int64_t kReopenFrames = 8192;  // HDF5 keeps about 100 bytes a frame of an open file's indices in memory

using Row = std::vector<std::uint64_t>;

double seconds_since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }

}  // namespace

struct RunWriter::Impl {
  std::string folder;
  std::unique_ptr<h5::File> file;
  RunTables tables;
  Column time, step, q, v;
  std::vector<Column> series, motion;
  Column series_steps, series_warnings;
  FrameDisplay display;
  FrameLists lists;
  FrameSensors sensors;
  h5::Dataset count;
  std::int64_t frames = 0;
  Clock::time_point last_flush = Clock::now(), last_xdmf = Clock::now();
  double flush_cost = 0.0, xdmf_cost = 0.0;  ///< [s] of the last time
  std::vector<double> motion_row;

  void make(const World& world, const RunInfo& info);
  void mark_writer();
  void open_all(const World& world, bool create);
  void open_series(bool create);
  template <class Visit>
  void for_each_column(const Visit& visit);
  void cut_all(std::int64_t whole);
  void add_series(const StepReport& report, int steps, std::span<const BodySample> samples);
  /// @param read  the sensors that have read the frame, or nothing
  void add(const World& world, const StepReport& frame, int steps, std::span<const BodySample> samples,
           std::span<const ContactSample> contacts, std::span<const std::pair<TileKey, double>> tiles,
           const Sensors* read);
  void flush();
  void write_xdmf();
  void go_on_after(const World& world, std::int64_t whole);
  void reopen(const World& world);
};

void RunWriter::Impl::make(const World& world, const RunInfo& info) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw InputError(fmt::format("{}: the folder cannot be made: {}", folder, error.message()));
  remove_run_files(folder);
  file = std::make_unique<h5::File>((fs::path(folder) / "run.h5").string(), h5::File::Mode::Create);
  file->attribute("/", "format", std::string(run_layout::kFormat));
  file->attribute("/", "version", std::int64_t{run_layout::kVersion});
  file->attribute("/", "brim_version", std::string(BRIM_VERSION));
  file->attribute("/", "scene", info.scene_name);
  file->attribute("/", "frame_time", info.frame_time);
  file->attribute("/", "steps_per_frame", std::int64_t{info.steps_per_frame});
  file->attribute("/", "scene_path", info.scene_path);
  mark_writer();
  write_tables(*file, world);
  open_all(world, true);
  write_whole((fs::path(folder) / "scene.json").string(), info.scene_text);
}

void RunWriter::Impl::mark_writer() {
  const ProcessMark me = this_process();
  file->attribute("/", "writer_pid", me.pid);
  file->attribute("/", "writer_host", me.host);
  file->attribute("/", "writer_started", me.started);
}

void RunWriter::Impl::open_series(bool create) {
  const auto number = [&](const std::string& path) {
    return create ? Column(*file, path, Type::Float64, {}, kRows) : Column(file->open(path));
  };
  for (const ReportField& f : report_fields()) {
    const std::string path = std::string("/series/") + f.name;
    // A run of an older version that is gone on with has zeros for what that version did not record.
    const bool missing = !create && !file->exists(path);
    series.push_back(missing ? Column(*file, path, Type::Float64, {}, kRows) : number(path));
    const std::vector<double> zeros(missing ? time.rows() : 0, 0.0);
    series.back().append(zeros.data(), zeros.size());
  }
  series_steps = number("/series/steps");
  series_warnings = number("/series/warnings");
}

void RunWriter::Impl::open_all(const World& world, bool create) {
  tables = read_tables(*file);
  if (create)
    for (const char* group : {"/frames", "/series", "/motion"}) file->group(group);
  const auto set = [&](const std::string& path, Type type, const Row& row, std::uint64_t chunk) {
    return create ? Column(*file, path, type, row, chunk) : Column(file->open(path));
  };
  const std::size_t nq = world.state().q.size(), nv = world.state().v.size();
  time = set("/frames/time", Type::Float64, {}, kRows);
  step = set("/frames/step", Type::Int64, {}, kRows);
  q = set("/frames/q", Type::Float64, {nq}, frame_chunk(8 * nq));
  v = set("/frames/v", Type::Float64, {nv}, frame_chunk(8 * nv));
  const std::int64_t none = 0;
  if (create) file->write("/frames/count", Type::Int64, Row{1}, &none);
  count = file->open("/frames/count");
  open_series(create);
  const auto bodies = static_cast<std::uint64_t>(world.body_count());
  for (const run_layout::MotionField& f : run_layout::kMotion) {
    const bool missing = !create && f.late && !file->exists(f.path);
    const Row row = f.width > 1 ? Row{bodies, 3} : Row{bodies};
    const std::uint64_t numbers = bodies * static_cast<std::uint64_t>(f.width);
    motion.push_back(create || missing ? Column(*file, f.path, Type::Float64, row, frame_chunk(8 * numbers))
                                       : Column(file->open(f.path)));
    const std::vector<double> zeros(missing ? numbers * time.rows() : 0, 0.0);
    if (missing) motion.back().append(zeros.data(), time.rows());
  }
  display = FrameDisplay(*file, tables, create);
  lists = FrameLists(*file, world, create);
  sensors = FrameSensors(*file, find_sensors(world), time.rows());
}

/// Calls visit(column) for every column that has a row a frame, but those of the display.
template <class Visit>
void RunWriter::Impl::for_each_column(const Visit& visit) {
  for (Column* c : {&time, &step, &q, &v, &series_steps, &series_warnings}) visit(*c);
  for (Column& c : series) visit(c);
  for (Column& c : motion) visit(c);
}

void RunWriter::Impl::cut_all(std::int64_t whole) {
  const auto n = static_cast<std::uint64_t>(whole);
  // First it is said that the later frames are gone: a reader must never count rows that are being cut.
  count.overwrite(&whole, Type::Int64);
  file->flush();
  for_each_column([&](Column& c) { c.cut(n); });
  display.cut(n);
  lists.cut(n);
  sensors.cut(n);
  file->flush();
  frames = whole;
}

/// Opens the file of a run, of which the first `whole` frames are kept.
void RunWriter::Impl::go_on_after(const World& world, std::int64_t whole) {
  file = std::make_unique<h5::File>((fs::path(folder) / "run.h5").string(), h5::File::Mode::Write);
  mark_writer();
  open_all(world, false);
  cut_all(whole);
}

/// Closes the file and opens it again: all that HDF5 keeps of an open file in memory goes.
void RunWriter::Impl::reopen(const World& world) {
  for_each_column([](Column& c) { c = Column(); });
  series.clear();
  motion.clear();
  display = FrameDisplay();
  lists = FrameLists();
  sensors = FrameSensors();
  count = h5::Dataset();
  file.reset();
  go_on_after(world, frames);
}

void RunWriter::Impl::add_series(const StepReport& report, int steps, std::span<const BodySample> samples) {
  for (std::size_t i = 0; i < series.size(); ++i) series[i].append_value(report_fields()[i].get(report));
  series_warnings.append_value(static_cast<double>(report.warnings.size()));
  series_steps.append_value(static_cast<double>(steps));
  for (std::size_t i = 0; i < motion.size(); ++i) {
    const run_layout::MotionField& field = run_layout::kMotion[i];
    const auto width = static_cast<std::size_t>(field.width);
    motion_row.resize(samples.size() * width);
    for (std::size_t b = 0; b < samples.size(); ++b) field.get(samples[b], &motion_row[b * width]);
    motion[i].append(motion_row.data(), 1);
  }
}

/// Rows first, then how many frames are whole: a reader of what a killed process left never sees half a frame.
void RunWriter::Impl::flush() {
  const Clock::time_point start = Clock::now();
  for_each_column([](Column& c) { c.flush(); });
  display.flush();
  lists.flush();
  sensors.flush();
  file->flush();
  count.overwrite(&frames, Type::Int64);
  file->flush();
  flush_cost = seconds_since(start);
  last_flush = Clock::now();
}

void RunWriter::Impl::write_xdmf() {
  const Clock::time_point start = Clock::now();
  const XdmfModel& model = display.xdmf();
  const std::int64_t most = std::max<std::int64_t>(1, kXdmfGrids / static_cast<std::int64_t>(model.bodies.size() + 1));
  write_whole((fs::path(folder) / "run.xdmf").string(), [&](std::ostream& out) {
    out << xdmf_head();
    for (std::int64_t first = 0; first < frames; first += most) {
      const auto from = static_cast<std::uint64_t>(first),
                 n = static_cast<std::uint64_t>(std::min(most, frames - first));
      XdmfFrames some{from, static_cast<std::size_t>(frames), std::vector<double>(n), display.xdmf_rows(from, n)};
      time.set().read(some.times.data(), n, from, n, Type::Float64);
      out << xdmf_frames(model, some);
    }
    out << xdmf_tail();
  });
  xdmf_cost = seconds_since(start);
  last_xdmf = Clock::now();
}

RunWriter::RunWriter(const std::string& folder, const World& world, const RunInfo& info)
    : impl_(std::make_unique<Impl>()) {
  impl_->folder = folder;
  impl_->make(world, info);
}

RunWriter::RunWriter(const std::string& folder, const World& world, std::int64_t frame)
    : impl_(std::make_unique<Impl>()) {
  impl_->folder = folder;
  impl_->go_on_after(world, frame + 1);
}

RunWriter::~RunWriter() = default;
RunWriter::RunWriter(RunWriter&&) noexcept = default;

std::int64_t RunWriter::frames() const { return impl_->frames; }

void RunWriter::add(const World& world, const StepReport& frame, int steps, std::span<const BodySample> samples) {
  impl_->add(world, frame, steps, samples, world.contacts(), world.active_tiles(), find_sensors(world));
}

void RunWriter::add(const World& world, const StepReport& frame, int steps, std::span<const BodySample> samples,
                    std::span<const ContactSample> contacts, std::span<const std::pair<TileKey, double>> tiles) {
  impl_->add(world, frame, steps, samples, contacts, tiles, nullptr);
}

void RunWriter::Impl::add(const World& world, const StepReport& frame, int steps, std::span<const BodySample> samples,
                          std::span<const ContactSample> contacts, std::span<const std::pair<TileKey, double>> tiles,
                          const Sensors* read) {
  const State& state = world.state();
  const bool first = frames == 0;
  time.append_value(state.time);
  step.append_value(state.step);
  q.append(state.q.data(), 1);
  v.append(state.v.data(), 1);
  add_series(frame, steps, samples);
  display.add(world);
  lists.add(world, frame, contacts, tiles);
  sensors.add(read);
  ++frames;
  // Slow frames are flushed one by one; fast ones together, so that flushing stays a small part of the time.
  if (first || seconds_since(last_flush) > std::min(kFlushSeconds, flush_cost / kFlushShare)) flush();
  if (first || seconds_since(last_xdmf) > std::max(kXdmfSeconds, xdmf_cost / kXdmfShare)) {
    flush();
    write_xdmf();
  }
  if (frames % kReopenFrames == 0) {
    flush();
    reopen(world);
  }
}

void RunWriter::flush() {
  impl_->flush();
  impl_->write_xdmf();
}

}  // namespace brim
