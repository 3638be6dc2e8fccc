#include "brim/record/run_writer.h"

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "brim/body/changing_surface.h"
#include "brim/record/h5.h"
#include "brim/record/process_mark.h"
#include "brim/record/run_layout.h"
#include "brim/record/xdmf.h"
#include "brim/world/report_fields.h"

namespace brim {

namespace fs = std::filesystem;
using h5::Dataset;
using h5::Type;
using Clock = std::chrono::steady_clock;

namespace {

constexpr const char* kFiles[] = {"run.h5", "run.xdmf", "scene.json", "summary.json"};
constexpr std::uint64_t kRows = 256;       // of small rows in a chunk
constexpr std::uint64_t kManyRows = 4096;  // of contacts and tiles
constexpr double kFlushSeconds = 1.0;
constexpr double kXdmfSeconds = 10.0;

using Row = std::vector<std::uint64_t>;

double seconds_since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }

/// Lists that differ in length from frame to frame: rows one after another, and where each frame's rows start.
struct Ragged {
  Dataset offset;
  std::vector<Dataset> columns;
  std::int64_t total = 0;

  void close_frame(std::int64_t rows) {
    total += rows;
    offset.append(&total, 1, Type::Int64);
  }
};

struct Column {
  const char* name;
  Type type;
  std::uint64_t width;  ///< 0: a plain number
};

Row row_of(const Column& c) { return c.width > 0 ? Row{c.width} : Row{}; }

const std::vector<Column> kContactColumns = {{"position", Type::Float32, 3},
                                             {"force", Type::Float32, 3},
                                             {"friction", Type::Float32, 3},
                                             {"overlap", Type::Float32, 0},
                                             {"pair", Type::Int32, 2}};
const std::vector<Column> kTileColumns = {{"key", Type::Int32, 3}, {"step", Type::Float64, 0}};
const std::vector<Column> kPairColumns = {{"parts", Type::Int32, 2},      {"force", Type::Float64, 3},
                                          {"friction", Type::Float64, 3}, {"center", Type::Float64, 3},
                                          {"contacts", Type::Int32, 0},   {"overlap", Type::Float64, 0},
                                          {"pressure", Type::Float64, 0}};
const std::vector<Column> kMemoryColumns = {{"value", Type::Float64, 0}};
const std::vector<Column> kVertexColumns = {{"position", Type::Float32, 3}};
const std::vector<Column> kTriangleColumns = {{"corner", Type::Int32, 3}};
const std::vector<Column> kWarningColumns = {{"text", Type::UInt8, 0}};

/// Appends one column of a list of structs, gathered by get(item, target).
template <class T, class List, class Get>
void append_column(Dataset& set, const List& list, int width, Type type, const Get& get) {
  std::vector<T> data(list.size() * static_cast<std::size_t>(width));
  T* at = data.data();
  for (const auto& item : list) {
    get(item, at);
    at += width;
  }
  set.append(data.data(), list.size(), type);
}

}  // namespace

void write_whole(const std::string& path, const std::string& text) {
  const std::string part = path + ".part";
  {
    std::ofstream out(part, std::ios::binary);
    out << text;
    out.flush();
    if (!out) throw InputError(fmt::format("{}: cannot be written; is the disk full or the folder protected?", part));
  }
  std::error_code error;
  fs::rename(part, path, error);
  if (error) throw InputError(fmt::format("{}: cannot be written: {}", path, error.message()));
}

void check_run_folder(const std::string& folder, bool force) {
  std::error_code error;
  if (!fs::exists(folder, error)) return;
  if (!fs::is_directory(folder, error)) throw InputError(fmt::format("{}: is a file; a run needs a folder", folder));
  if (fs::is_empty(folder, error)) return;
  if (!fs::exists(fs::path(folder) / "run.h5", error))
    throw InputError(
        fmt::format("{}: holds other files; a run needs a new or empty folder, or one with an older run", folder));
  if (!force)
    throw InputError(fmt::format("{}: holds a run already; --force replaces it, --resume goes on with it", folder));
}

/// Display of a body: one row of positions a frame, or of a surface that changes, lists of vertices and triangles.
struct Shown {
  Dataset positions;
  Ragged vertices, triangles;
  bool changing = false;
};

struct RunWriter::Impl {
  std::string folder;
  std::unique_ptr<h5::File> file;
  Dataset time, step, q, v;
  std::vector<Dataset> series, motion;
  std::vector<Shown> display;
  Dataset series_steps, series_warnings;
  Ragged contacts, tiles, pairs, memory, warnings;
  std::vector<double> times;
  XdmfModel xdmf;
  Clock::time_point last_flush = Clock::now(), last_xdmf = Clock::now();
  double flush_cost = 0.0;  ///< [s] of the last flush
  std::vector<Vec3f> positions;
  std::vector<Triangle> corners;
  std::vector<std::vector<Vec3f>> first_positions;  ///< of bodies that have not moved yet

  void make(const World& world, const RunInfo& info);
  void mark_writer();
  void describe(const World& world);
  void open_all(const World& world, bool create);
  Ragged open_ragged(const std::string& group, const std::vector<Column>& columns, bool create);
  void cut_all(std::int64_t frames);
  void add_display(const World& world);
  void add_lists(const World& world, const StepReport& report);
  void write_xdmf() { write_whole((fs::path(folder) / "run.xdmf").string(), xdmf_text(xdmf, times)); }
};

void RunWriter::Impl::make(const World& world, const RunInfo& info) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw InputError(fmt::format("{}: the folder cannot be made: {}", folder, error.message()));
  for (const char* name : kFiles) fs::remove(fs::path(folder) / name, error);
  file = std::make_unique<h5::File>((fs::path(folder) / "run.h5").string(), h5::File::Mode::Create);
  file->attribute("/", "format", std::string(run_layout::kFormat));
  file->attribute("/", "version", std::int64_t{run_layout::kVersion});
  file->attribute("/", "brim_version", std::string(BRIM_VERSION));
  file->attribute("/", "scene", info.scene_name);
  file->attribute("/", "frame_time", info.frame_time);
  file->attribute("/", "steps_per_frame", std::int64_t{info.steps_per_frame});
  file->attribute("/", "scene_path", info.scene_path);
  mark_writer();
  describe(world);
  open_all(world, true);
  write_whole((fs::path(folder) / "scene.json").string(), info.scene_text);
}

void RunWriter::Impl::mark_writer() {
  const ProcessMark me = this_process();
  file->attribute("/", "writer_pid", me.pid);
  file->attribute("/", "writer_host", me.host);
  file->attribute("/", "writer_started", me.started);
}

void RunWriter::Impl::describe(const World& world) {
  file->group("/bodies");
  file->group("/parts");
  std::int64_t q_offset = 0, v_offset = 0;
  for (int b = 0; b < world.body_count(); ++b) {
    const Body& body = world.body(b);
    const Display& d = body.display();
    const std::string at = "/bodies/" + std::to_string(b);
    file->group(at);
    file->attribute(at, "name", body.name());
    file->attribute(at, "kind", std::string(body.kind()));
    file->attribute(at, "display_kind", std::string(run_layout::display_word(d.kind)));
    file->attribute(at, "two_sided", std::int64_t{d.two_sided});
    file->attribute(at, "radius", d.radius);
    file->attribute(at, "vertices", static_cast<std::int64_t>(d.vertices));
    file->attribute(at, "changing", std::int64_t{changing_surface(body) != nullptr});
    file->attribute(at, "q_offset", q_offset);
    file->attribute(at, "q_size", static_cast<std::int64_t>(body.q_size()));
    file->attribute(at, "v_offset", v_offset);
    file->attribute(at, "v_size", static_cast<std::int64_t>(body.v_size()));
    file->attribute(at, "immobile", std::int64_t{body.immobile()});
    file->attribute(at, "mass", body.mass());
    file->attribute(at, "parts", std::int64_t{body.part_count()});
    q_offset += static_cast<std::int64_t>(body.q_size());
    v_offset += static_cast<std::int64_t>(body.v_size());
    if (d.kind == Display::Kind::Triangles && !changing_surface(body))
      file->write(at + "/triangles", Type::Int32, Row{d.triangles.size(), 3}, d.triangles.data());
    if (d.kind == Display::Kind::Lines) file->write(at + "/lines", Type::Int32, Row{d.lines.size(), 2}, d.lines.data());
  }
  for (int p = 0; p < world.part_count(); ++p) {
    const PartRef ref = world.part(p);
    const Body& body = world.body(ref.body);
    const PartInfo part = body.part(ref.index);
    const std::string at = "/parts/" + std::to_string(p);
    file->group(at);
    file->attribute(at, "name", body.part_count() > 1 ? fmt::format("{}/{}", body.name(), ref.index) : body.name());
    file->attribute(at, "body", std::int64_t{ref.body});
    file->attribute(at, "part", std::int64_t{ref.index});
    file->attribute(at, "material", part.material.name);
    file->attribute(at, "voxel_size", part.voxel_size);
  }
}

Ragged RunWriter::Impl::open_ragged(const std::string& group, const std::vector<Column>& columns, bool create) {
  Ragged r;
  if (create) {
    file->group(group);
    r.offset = file->growing(group + "/offset", Type::Int64, {}, kRows, 0);
    r.close_frame(0);
    for (const Column& c : columns)
      r.columns.push_back(file->growing(group + "/" + c.name, c.type, row_of(c), kManyRows, 0));
  } else {
    r.offset = file->open(group + "/offset");
    for (const Column& c : columns) r.columns.push_back(file->open(group + "/" + c.name));
  }
  return r;
}

void RunWriter::Impl::open_all(const World& world, bool create) {
  const auto set = [&](const std::string& path, Type type, const Row& row, std::uint64_t chunk, int deflate) {
    return create ? file->growing(path, type, row, chunk, deflate) : file->open(path);
  };
  if (create)
    for (const char* group : {"/frames", "/display", "/series", "/motion"}) file->group(group);
  time = set("/frames/time", Type::Float64, {}, kRows, 0);
  step = set("/frames/step", Type::Int64, {}, kRows, 0);
  q = set("/frames/q", Type::Float64, {world.state().q.size()}, 1, 0);
  v = set("/frames/v", Type::Float64, {world.state().v.size()}, 1, 0);
  for (const ReportField& f : report_fields()) {
    const std::string path = std::string("/series/") + f.name;
    // A run of an older version that is gone on with has zeros for what that version did not record.
    const bool missing = !create && !file->exists(path);
    series.push_back(missing ? file->growing(path, Type::Float64, {}, kRows, 0)
                             : set(path, Type::Float64, {}, kRows, 0));
    const std::vector<double> zeros(missing ? time.shape()[0] : 0, 0.0);
    if (missing) series.back().append(zeros.data(), zeros.size(), Type::Float64);
  }
  series_steps = set("/series/steps", Type::Float64, {}, kRows, 0);
  series_warnings = set("/series/warnings", Type::Float64, {}, kRows, 0);
  const auto bodies = static_cast<std::uint64_t>(world.body_count());
  for (const run_layout::MotionField& f : run_layout::kMotion)
    motion.push_back(set(f.path, Type::Float64, f.width > 1 ? Row{bodies, 3} : Row{bodies}, 16, 0));
  for (int b = 0; b < world.body_count(); ++b) {
    const Display& d = world.body(b).display();
    const std::string at = "/display/" + std::to_string(b);
    if (create) file->group(at);
    Shown shown;
    shown.changing = changing_surface(world.body(b)) != nullptr;
    if (shown.changing) {
      shown.vertices = open_ragged(at + "/vertices", kVertexColumns, create);
      shown.triangles = open_ragged(at + "/triangles", kTriangleColumns, create);
    } else {
      shown.positions = set(at + "/positions", Type::Float32, {d.vertices, 3}, 1, 1);
    }
    xdmf.bodies.push_back({world.body(b).name(),
                           b,
                           d.kind,
                           d.vertices,
                           d.kind == Display::Kind::Triangles ? d.triangles.size() : d.lines.size(),
                           world.body(b).immobile() && !shown.changing,
                           shown.changing,
                           {0},
                           {0}});
    display.push_back(std::move(shown));
  }
  first_positions.resize(display.size());
  contacts = open_ragged("/contacts", kContactColumns, create);
  tiles = open_ragged("/tiles", kTileColumns, create);
  pairs = open_ragged("/pairs", kPairColumns, create);
  memory = open_ragged("/memory", kMemoryColumns, create);
  warnings = open_ragged("/warnings", kWarningColumns, create);
}

void RunWriter::Impl::cut_all(std::int64_t frames) {
  const auto n = static_cast<std::uint64_t>(frames);
  for (Dataset* d : {&time, &step, &q, &v, &series_steps, &series_warnings}) d->cut(n);
  for (Dataset& d : series) d.cut(n);
  for (Dataset& d : motion) d.cut(n);
  std::vector<Ragged*> lists = {&contacts, &tiles, &pairs, &memory, &warnings};
  for (Shown& d : display) {
    if (!d.changing)
      d.positions.cut(n);
    else
      lists.insert(lists.end(), {&d.vertices, &d.triangles});
  }
  for (Ragged* r : lists) {
    r->offset.cut(n + 1);
    r->offset.read(&r->total, n, 1, Type::Int64);
    for (Dataset& d : r->columns) d.cut(static_cast<std::uint64_t>(r->total));
  }
  times.resize(n);
  time.read(times.data(), 0, n, Type::Float64);
  for (std::size_t b = 0; b < display.size(); ++b) {
    XdmfModel::Item& item = xdmf.bodies[b];
    if (item.changing) {
      for (auto [offsets, list] : {std::pair(&item.vertex_offset, &display[b].vertices),
                                   std::pair(&item.cell_offset, &display[b].triangles)}) {
        offsets->resize(n + 1);
        list->offset.read(offsets->data(), 0, n + 1, Type::Int64);
      }
      continue;
    }
    item.still = item.still && display[b].positions.shape()[0] == 1;
    if (!item.still) continue;
    first_positions[b].resize(item.vertices);
    display[b].positions.read(first_positions[b].data(), 0, 1, Type::Float32);
  }
}

void RunWriter::Impl::add_display(const World& world) {
  for (std::size_t b = 0; b < display.size(); ++b) {
    const Body& body = world.body(static_cast<int>(b));
    XdmfModel::Item& item = xdmf.bodies[b];
    if (const ChangingSurface* surface = changing_surface(body)) {
      surface->display_surface(positions, corners);
      display[b].vertices.columns[0].append(positions.data(), positions.size(), Type::Float32);
      display[b].vertices.close_frame(static_cast<std::int64_t>(positions.size()));
      display[b].triangles.columns[0].append(corners.data(), corners.size(), Type::Int32);
      display[b].triangles.close_frame(static_cast<std::int64_t>(corners.size()));
      item.vertex_offset.push_back(display[b].vertices.total);
      item.cell_offset.push_back(display[b].triangles.total);
      continue;
    }
    display_now(body, positions);
    if (times.empty()) {
      if (item.still) first_positions[b] = positions;
    } else if (item.still) {
      if (positions == first_positions[b]) continue;
      // It moves after all: the frames that stood for themselves get their rows.
      for (std::size_t f = 1; f < times.size(); ++f)
        display[b].positions.append(first_positions[b].data(), 1, Type::Float32);
      item.still = false;
    }
    display[b].positions.append(positions.data(), 1, Type::Float32);
  }
}

void RunWriter::Impl::add_lists(const World& world, const StepReport& report) {
  const auto copy3 = [](const auto& x, auto* to) {
    for (int a = 0; a < 3; ++a) to[a] = x[a];
  };
  const std::span<const ContactSample> c = world.contacts();
  append_column<float>(contacts.columns[0], c, 3, Type::Float32,
                       [&](const ContactSample& s, float* x) { copy3(s.position, x); });
  append_column<float>(contacts.columns[1], c, 3, Type::Float32,
                       [&](const ContactSample& s, float* x) { copy3(s.force, x); });
  append_column<float>(contacts.columns[2], c, 3, Type::Float32,
                       [&](const ContactSample& s, float* x) { copy3(s.friction, x); });
  append_column<float>(contacts.columns[3], c, 1, Type::Float32,
                       [](const ContactSample& s, float* x) { *x = s.overlap; });
  append_column<std::int32_t>(contacts.columns[4], c, 2, Type::Int32, [](const ContactSample& s, std::int32_t* x) {
    x[0] = s.part_a;
    x[1] = s.part_b;
  });
  contacts.close_frame(static_cast<std::int64_t>(c.size()));

  const auto t = world.active_tiles();
  append_column<std::int32_t>(tiles.columns[0], t, 3, Type::Int32, [](const auto& tile, std::int32_t* x) {
    x[0] = tile.first.x;
    x[1] = tile.first.y;
    x[2] = tile.first.z;
  });
  append_column<double>(tiles.columns[1], t, 1, Type::Float64, [](const auto& tile, double* x) { *x = tile.second; });
  tiles.close_frame(static_cast<std::int64_t>(t.size()));

  const auto& p = report.pairs;
  const auto vectors = [&](std::size_t column, Vec3 PairReport::*member) {
    append_column<double>(pairs.columns[column], p, 3, Type::Float64,
                          [&](const PairReport& r, double* x) { copy3(r.*member, x); });
  };
  append_column<std::int32_t>(pairs.columns[0], p, 2, Type::Int32, [](const PairReport& r, std::int32_t* x) {
    x[0] = r.part_a;
    x[1] = r.part_b;
  });
  vectors(1, &PairReport::force_on_a);
  vectors(2, &PairReport::friction_on_a);
  vectors(3, &PairReport::center);
  append_column<std::int32_t>(pairs.columns[4], p, 1, Type::Int32,
                              [](const PairReport& r, std::int32_t* x) { *x = r.contacts; });
  append_column<double>(pairs.columns[5], p, 1, Type::Float64,
                        [](const PairReport& r, double* x) { *x = r.worst_overlap; });
  append_column<double>(pairs.columns[6], p, 1, Type::Float64,
                        [](const PairReport& r, double* x) { *x = r.worst_pressure; });
  pairs.close_frame(static_cast<std::int64_t>(p.size()));

  const std::vector<double>& m = world.state().memory;
  memory.columns[0].append(m.data(), m.size(), Type::Float64);
  memory.close_frame(static_cast<std::int64_t>(m.size()));

  std::string text;
  for (const Warning& w : report.warnings)
    text += nlohmann::ordered_json{{"time", w.time}, {"code", w.code}, {"message", w.message}}.dump() + "\n";
  warnings.columns[0].append(text.data(), text.size(), Type::UInt8);
  warnings.close_frame(static_cast<std::int64_t>(text.size()));
}

RunWriter::RunWriter(const std::string& folder, const World& world, const RunInfo& info)
    : impl_(std::make_unique<Impl>()) {
  impl_->folder = folder;
  impl_->make(world, info);
}

RunWriter::RunWriter(const std::string& folder, const World& world, std::int64_t frame)
    : impl_(std::make_unique<Impl>()) {
  impl_->folder = folder;
  impl_->file = std::make_unique<h5::File>((fs::path(folder) / "run.h5").string(), h5::File::Mode::Write);
  impl_->mark_writer();
  impl_->open_all(world, false);
  impl_->cut_all(frame + 1);
}

RunWriter::~RunWriter() = default;
RunWriter::RunWriter(RunWriter&&) noexcept = default;

std::int64_t RunWriter::frames() const { return static_cast<std::int64_t>(impl_->times.size()); }

void RunWriter::add(const World& world, const StepReport& frame, int steps, std::span<const BodySample> samples) {
  Impl& d = *impl_;
  const State& state = world.state();
  const bool first = d.times.empty();
  d.time.append(&state.time, 1, Type::Float64);
  d.step.append(&state.step, 1, Type::Int64);
  d.q.append(state.q.data(), 1, Type::Float64);
  d.v.append(state.v.data(), 1, Type::Float64);
  for (std::size_t i = 0; i < d.series.size(); ++i) {
    const double x = report_fields()[i].get(frame);
    d.series[i].append(&x, 1, Type::Float64);
  }
  const double count = static_cast<double>(frame.warnings.size()), taken = steps;
  d.series_warnings.append(&count, 1, Type::Float64);
  d.series_steps.append(&taken, 1, Type::Float64);
  std::vector<double> row;
  for (std::size_t i = 0; i < d.motion.size(); ++i) {
    const run_layout::MotionField& field = run_layout::kMotion[i];
    row.assign(samples.size() * static_cast<std::size_t>(field.width), 0.0);
    for (std::size_t b = 0; b < samples.size(); ++b)
      field.get(samples[b], row.data() + b * static_cast<std::size_t>(field.width));
    d.motion[i].append(row.data(), 1, Type::Float64);
  }
  d.add_display(world);
  d.add_lists(world, frame);
  d.times.push_back(state.time);
  // Slow frames are flushed one by one; fast ones together, so that flushing stays a small part of the time.
  if (first || seconds_since(d.last_flush) > std::min(kFlushSeconds, 20.0 * d.flush_cost)) {
    const Clock::time_point start = Clock::now();
    d.file->flush();
    d.flush_cost = seconds_since(start);
    d.last_flush = Clock::now();
  }
  if (first || seconds_since(d.last_xdmf) > kXdmfSeconds) {
    d.write_xdmf();
    d.last_xdmf = Clock::now();
  }
}

void RunWriter::flush() {
  impl_->file->flush();
  impl_->write_xdmf();
}

}  // namespace brim
