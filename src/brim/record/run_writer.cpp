#include "brim/record/run_writer.h"

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "brim/body/changing_surface.h"
#include "brim/body/posed_display.h"
#include "brim/record/column.h"
#include "brim/record/h5.h"
#include "brim/record/process_mark.h"
#include "brim/record/run_layout.h"
#include "brim/record/run_tables.h"
#include "brim/record/scene_change.h"
#include "brim/record/xdmf.h"
#include "brim/world/attachment.h"
#include "brim/world/report_fields.h"

namespace brim {

namespace fs = std::filesystem;
using h5::Type;
using Clock = std::chrono::steady_clock;

namespace {

constexpr const char* kFiles[] = {"run.h5.journal", "run.h5", "run.xdmf", "scene.json", "summary.json"};
constexpr std::uint64_t kRows = 256;          // of numbers in a chunk
constexpr std::uint64_t kContactRows = 4096;  // in a chunk, and of what comes in other numbers:
constexpr std::uint64_t kTileRows = 1024, kPairRows = 512, kTextRows = 4096;
constexpr double kFlushSeconds = 1.0;
constexpr double kFlushShare = 0.02;  // of the time, at most, when frames are fast
constexpr double kXdmfSeconds = 10.0;
constexpr double kXdmfShare = 0.01;

using Row = std::vector<std::uint64_t>;

double seconds_since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }

/// Lists that differ in length from frame to frame: rows one after another, and where each frame's rows start.
struct Ragged {
  Column offset;
  std::vector<Column> columns;
  std::int64_t total = 0;

  void close_frame(std::int64_t rows) {
    total += rows;
    offset.append_value(total);
  }
};

struct ColumnType {
  const char* name;
  Type type;
  std::uint64_t width;  ///< 0: a plain number
};

Row row_of(const ColumnType& c) { return c.width > 0 ? Row{c.width} : Row{}; }

const std::vector<ColumnType> kContactColumns = {{"position", Type::Float32, 3},
                                                 {"force", Type::Float32, 3},
                                                 {"friction", Type::Float32, 3},
                                                 {"overlap", Type::Float32, 0},
                                                 {"pair", Type::Int32, 2}};
const std::vector<ColumnType> kTileColumns = {{"key", Type::Int32, 3}, {"step", Type::Float64, 0}};
const std::vector<ColumnType> kPairColumns = {{"parts", Type::Int32, 2},      {"force", Type::Float64, 3},
                                              {"friction", Type::Float64, 3}, {"center", Type::Float64, 3},
                                              {"contacts", Type::Int32, 0},   {"overlap", Type::Float64, 0},
                                              {"pressure", Type::Float64, 0}};
const std::vector<ColumnType> kLinkColumns = {{"force", Type::Float64, 3},
                                              {"error", Type::Float64, 0},
                                              {"coordinate", Type::Float64, 0},
                                              {"effort", Type::Float64, 0},
                                              {"broken", Type::Int32, 0}};
const std::vector<ColumnType> kMemoryColumns = {{"value", Type::Float64, 0}};
const std::vector<ColumnType> kVertexColumns = {{"position", Type::Float32, 3}};
const std::vector<ColumnType> kTriangleColumns = {{"corner", Type::Int32, 3}};
const std::vector<ColumnType> kWarningColumns = {{"text", Type::UInt8, 0}};

/// Appends one column of a list of structs, gathered by get(item, target).
template <class T, class List, class Get>
void append_column(Column& column, std::vector<std::byte>& room, const List& list, std::size_t width, const Get& get) {
  room.resize(list.size() * width * sizeof(T));
  T* at = reinterpret_cast<T*>(room.data());
  for (const auto& item : list) {
    get(item, at);
    at += width;
  }
  column.append(room.data(), list.size());
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

void remove_run_files(const std::string& folder) {
  std::error_code error;
  for (const char* name : kFiles) fs::remove(fs::path(folder) / name, error);
  for (const std::string& name : earlier_scenes(folder)) fs::remove(fs::path(folder) / name, error);
}

/// The surface of a body that is another one in every frame.
struct Surface {
  std::size_t body = 0;
  Ragged vertices, triangles;
};

struct RunWriter::Impl {
  std::string folder;
  std::unique_ptr<h5::File> file;
  RunTables tables;
  Column time, step, q, v, rotation, translation, positions;
  std::vector<Column> series, motion;
  Column series_steps, series_warnings;
  std::vector<Surface> surfaces;
  Ragged contacts, tiles, pairs, memory, warnings;
  std::optional<Ragged> links;  ///< of worlds with attachments
  h5::Dataset count, still_set;
  std::vector<std::int64_t> still;  ///< of each body: 1 until its display differs from the first
  bool still_changed = false;
  std::vector<double> times;
  XdmfModel xdmf;
  Clock::time_point last_flush = Clock::now(), last_xdmf = Clock::now();
  double flush_cost = 0.0, xdmf_cost = 0.0;  ///< [s] of the last time
  // Rows of the frame, and of the first one.
  std::vector<double> rotation_row, translation_row, first_rotation, first_translation;
  std::vector<Vec3f> position_row, first_positions;
  std::vector<Vec3f> vertices;
  std::vector<Triangle> corners;
  std::vector<std::byte> room;

  void make(const World& world, const RunInfo& info);
  void mark_writer();
  void open_all(const World& world, bool create);
  void open_series(bool create);
  void open_display(bool create);
  void describe_xdmf();
  Ragged open_ragged(const std::string& group, const std::vector<ColumnType>& columns, std::uint64_t chunk,
                     bool create);
  template <class Visit>
  void for_each_column(const Visit& visit);
  void cut_all(std::int64_t frames);
  void add_series(const StepReport& report, int steps, std::span<const BodySample> samples);
  void add_display(const World& world);
  void watch_still();
  void add_contacts(std::span<const ContactSample> list);
  void add_tiles(std::span<const std::pair<TileKey, double>> list);
  void add_pairs(const std::vector<PairReport>& list);
  void add_links(const std::vector<LinkReport>& list);
  std::vector<Ragged*> lists();
  void add_warnings(const std::vector<Warning>& list);
  void flush();
  void write_xdmf();
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

Ragged RunWriter::Impl::open_ragged(const std::string& group, const std::vector<ColumnType>& columns,
                                    std::uint64_t chunk, bool create) {
  Ragged r;
  if (create) {
    file->group(group);
    r.offset = Column(*file, group + "/offset", Type::Int64, {}, kRows);
    r.close_frame(0);
    for (const ColumnType& c : columns) r.columns.emplace_back(*file, group + "/" + c.name, c.type, row_of(c), chunk);
  } else {
    r.offset = Column(file->open(group + "/offset"));
    for (const ColumnType& c : columns) r.columns.emplace_back(file->open(group + "/" + c.name));
  }
  return r;
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

void RunWriter::Impl::open_display(bool create) {
  const auto set = [&](const std::string& path, Type type, const Row& row, std::size_t bytes) {
    return create ? Column(*file, path, type, row, frame_chunk(bytes)) : Column(file->open(path));
  };
  const std::size_t pieces = tables.piece_mesh.size(), n = tables.positions;
  rotation = set("/poses/rotation", Type::Float64, {pieces, 9}, 72 * pieces);
  translation = set("/poses/translation", Type::Float64, {pieces, 3}, 24 * pieces);
  positions = set("/display/positions", Type::Float32, {n, 3}, 12 * n);
  for (std::size_t b = 0; b < tables.bodies.size(); ++b) {
    if (!tables.bodies[b].changing) continue;
    const std::string at = "/display/" + std::to_string(b);
    if (create) file->group(at);
    surfaces.push_back({b, open_ragged(at + "/vertices", kVertexColumns, kContactRows, create),
                        open_ragged(at + "/triangles", kTriangleColumns, kContactRows, create)});
  }
  still.resize(tables.bodies.size());
  still_set = file->open("/bodies/still");
  if (!still.empty()) still_set.read(still.data(), still.size(), 0, still.size(), Type::Int64);
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
  for (const run_layout::MotionField& f : run_layout::kMotion)
    motion.push_back(set(f.path, Type::Float64, f.width > 1 ? Row{bodies, 3} : Row{bodies},
                         frame_chunk(8 * bodies * static_cast<std::size_t>(f.width))));
  open_display(create);
  contacts = open_ragged("/contacts", kContactColumns, kContactRows, create);
  tiles = open_ragged("/tiles", kTileColumns, kTileRows, create);
  pairs = open_ragged("/pairs", kPairColumns, kPairRows, create);
  memory = open_ragged("/memory", kMemoryColumns, kContactRows, create);
  warnings = open_ragged("/warnings", kWarningColumns, kTextRows, create);
  if (create ? world.attachment_count() > 0 : file->exists("/links")) {
    links = open_ragged("/links", kLinkColumns, kPairRows, create);
    std::string names;
    for (int i = 0; i < world.attachment_count(); ++i) names += (i > 0 ? "\n" : "") + world.attachment(i).name;
    if (create) file->attribute("/links", "names", names);
  }
  describe_xdmf();
}

void RunWriter::Impl::describe_xdmf() {
  xdmf.pieces = tables.piece_mesh.size();
  xdmf.positions = tables.positions;
  for (std::size_t b = 0; b < tables.bodies.size(); ++b) {
    const RecordedBody& body = tables.bodies[b];
    const RunTables::Place& place = tables.places[b];
    const std::size_t triangles = place.pieces > 0 ? 0 : body.display.triangles.size();
    if (place.pieces == 0)
      xdmf.bodies.push_back({body.name,
                             static_cast<int>(b),
                             body.display.kind,
                             body.display.vertices,
                             body.display.kind == Display::Kind::Lines ? body.display.lines.size() : triangles,
                             static_cast<std::size_t>(std::max<std::int64_t>(place.first_position, 0)),
                             body.display.kind == Display::Kind::Lines ? xdmf.lines : xdmf.triangles,
                             body.changing,
                             {0},
                             {0}});
    xdmf.triangles += triangles;
    xdmf.lines += body.display.lines.size();
  }
}

std::vector<Ragged*> RunWriter::Impl::lists() {
  std::vector<Ragged*> all = {&contacts, &tiles, &pairs, &memory, &warnings};
  if (links) all.push_back(&*links);
  for (Surface& s : surfaces) all.insert(all.end(), {&s.vertices, &s.triangles});
  return all;
}

/// Calls visit(column, list) for every column; list is the ragged list it is of, or nothing where it has a row a frame.
template <class Visit>
void RunWriter::Impl::for_each_column(const Visit& visit) {
  const auto ragged = [&](Ragged& r) {
    for (Column& c : r.columns) visit(c, &r);
    visit(r.offset, nullptr);
  };
  for (Column* c : {&time, &step, &q, &v, &rotation, &translation, &positions, &series_steps, &series_warnings})
    visit(*c, nullptr);
  for (Column& c : series) visit(c, nullptr);
  for (Column& c : motion) visit(c, nullptr);
  for (Ragged* r : lists()) ragged(*r);
}

void RunWriter::Impl::cut_all(std::int64_t frames) {
  const auto n = static_cast<std::uint64_t>(frames);
  // First it is said that the later frames are gone: a reader must never count rows that are being cut.
  count.overwrite(&frames, Type::Int64);
  file->flush();
  const std::vector<Ragged*> lists = this->lists();
  for (Ragged* r : lists) r->offset.set().read(&r->total, 1, n, 1, Type::Int64);
  for_each_column([&](Column& c, const Ragged* list) {
    const bool offset = std::ranges::any_of(lists, [&](const Ragged* r) { return &r->offset == &c; });
    c.cut(list != nullptr ? static_cast<std::uint64_t>(list->total) : offset ? n + 1 : n);
  });
  file->flush();
  times.resize(n);
  time.set().read(times.data(), n, 0, n, Type::Float64);
  for (XdmfModel::Item& item : xdmf.bodies)
    for (const Surface& s : surfaces)
      if (static_cast<std::size_t>(item.index) == s.body)
        for (auto [offsets, list] :
             {std::pair(&item.vertex_offset, &s.vertices), std::pair(&item.cell_offset, &s.triangles)}) {
          offsets->resize(n + 1);
          list->offset.set().read(offsets->data(), n + 1, 0, n + 1, Type::Int64);
        }
  if (n == 0) return;
  const auto first_row = [](const Column& c, auto& row, std::size_t size, std::size_t numbers, Type type) {
    row.resize(size);
    if (size > 0) c.set().read(row.data(), numbers, 0, 1, type);
  };
  const std::size_t pieces = tables.piece_mesh.size();
  first_row(rotation, first_rotation, 9 * pieces, 9 * pieces, Type::Float64);
  first_row(translation, first_translation, 3 * pieces, 3 * pieces, Type::Float64);
  first_row(positions, first_positions, tables.positions, 3 * tables.positions, Type::Float32);
}

void RunWriter::Impl::add_series(const StepReport& report, int steps, std::span<const BodySample> samples) {
  for (std::size_t i = 0; i < series.size(); ++i) series[i].append_value(report_fields()[i].get(report));
  series_warnings.append_value(static_cast<double>(report.warnings.size()));
  series_steps.append_value(static_cast<double>(steps));
  for (std::size_t i = 0; i < motion.size(); ++i) {
    const run_layout::MotionField& field = run_layout::kMotion[i];
    const auto width = static_cast<std::size_t>(field.width);
    room.resize(samples.size() * width * sizeof(double));
    auto* row = reinterpret_cast<double*>(room.data());
    for (std::size_t b = 0; b < samples.size(); ++b) field.get(samples[b], row + b * width);
    motion[i].append(row, 1);
  }
}

void RunWriter::Impl::add_display(const World& world) {
  rotation_row.resize(9 * tables.piece_mesh.size());
  translation_row.resize(3 * tables.piece_mesh.size());
  position_row.resize(tables.positions);
  for (std::size_t b = 0; b < tables.bodies.size(); ++b) {
    const RunTables::Place& place = tables.places[b];
    const Body& body = world.body(static_cast<int>(b));
    if (place.pieces > 0) {
      const PosedDisplay* posed = posed_display(body);
      for (std::size_t i = 0; i < place.pieces; ++i) {
        const Pose& pose = posed->piece(i).pose();
        double* const r = &rotation_row[9 * (place.first_piece + i)];
        double* const t = &translation_row[3 * (place.first_piece + i)];
        for (int a = 0; a < 9; ++a) r[a] = pose.rotation(a / 3, a % 3);
        for (int a = 0; a < 3; ++a) t[a] = pose.translation[a];
      }
    } else if (place.first_position >= 0) {
      body.display_positions(
          std::span(position_row).subspan(static_cast<std::size_t>(place.first_position), body.display().vertices));
    }
  }
  rotation.append(rotation_row.data(), 1);
  translation.append(translation_row.data(), 1);
  positions.append(position_row.data(), 1);
  for (Surface& s : surfaces) {
    changing_surface(world.body(static_cast<int>(s.body)))->display_surface(vertices, corners);
    s.vertices.columns[0].append(vertices.data(), vertices.size());
    s.vertices.close_frame(static_cast<std::int64_t>(vertices.size()));
    s.triangles.columns[0].append(corners.data(), corners.size());
    s.triangles.close_frame(static_cast<std::int64_t>(corners.size()));
    for (XdmfModel::Item& item : xdmf.bodies)
      if (static_cast<std::size_t>(item.index) == s.body) {
        item.vertex_offset.push_back(s.vertices.total);
        item.cell_offset.push_back(s.triangles.total);
      }
  }
  watch_still();
}

void RunWriter::Impl::watch_still() {
  if (times.empty()) {
    first_rotation = rotation_row, first_translation = translation_row, first_positions = position_row;
    return;
  }
  const auto same = [](const auto& a, const auto& b, std::size_t first, std::size_t size) {
    return std::equal(a.begin() + static_cast<std::ptrdiff_t>(first),
                      a.begin() + static_cast<std::ptrdiff_t>(first + size),
                      b.begin() + static_cast<std::ptrdiff_t>(first));
  };
  for (std::size_t b = 0; b < still.size(); ++b) {
    if (still[b] == 0) continue;
    const RunTables::Place& place = tables.places[b];
    if (same(rotation_row, first_rotation, 9 * place.first_piece, 9 * place.pieces) &&
        same(translation_row, first_translation, 3 * place.first_piece, 3 * place.pieces) &&
        (place.first_position < 0 || same(position_row, first_positions, static_cast<std::size_t>(place.first_position),
                                          tables.bodies[b].display.vertices)))
      continue;
    still[b] = 0;
    still_changed = true;
  }
}

void RunWriter::Impl::add_contacts(std::span<const ContactSample> list) {
  const auto copy3 = [](const Vec3f& x, float* to) { to[0] = x[0], to[1] = x[1], to[2] = x[2]; };
  append_column<float>(contacts.columns[0], room, list, 3, [&](const auto& c, float* x) { copy3(c.position, x); });
  append_column<float>(contacts.columns[1], room, list, 3, [&](const auto& c, float* x) { copy3(c.force, x); });
  append_column<float>(contacts.columns[2], room, list, 3, [&](const auto& c, float* x) { copy3(c.friction, x); });
  append_column<float>(contacts.columns[3], room, list, 1, [](const auto& c, float* x) { *x = c.overlap; });
  append_column<std::int32_t>(contacts.columns[4], room, list, 2, [](const auto& c, std::int32_t* x) {
    x[0] = c.part_a;
    x[1] = c.part_b;
  });
  contacts.close_frame(static_cast<std::int64_t>(list.size()));
}

void RunWriter::Impl::add_tiles(std::span<const std::pair<TileKey, double>> list) {
  append_column<std::int32_t>(tiles.columns[0], room, list, 3, [](const auto& tile, std::int32_t* x) {
    x[0] = tile.first.x;
    x[1] = tile.first.y;
    x[2] = tile.first.z;
  });
  append_column<double>(tiles.columns[1], room, list, 1, [](const auto& tile, double* x) { *x = tile.second; });
  tiles.close_frame(static_cast<std::int64_t>(list.size()));
}

void RunWriter::Impl::add_pairs(const std::vector<PairReport>& list) {
  const auto vectors = [&](std::size_t column, Vec3 PairReport::*member) {
    append_column<double>(pairs.columns[column], room, list, 3, [&](const PairReport& r, double* x) {
      for (int a = 0; a < 3; ++a) x[a] = (r.*member)[a];
    });
  };
  append_column<std::int32_t>(pairs.columns[0], room, list, 2, [](const PairReport& r, std::int32_t* x) {
    x[0] = r.part_a;
    x[1] = r.part_b;
  });
  vectors(1, &PairReport::force_on_a);
  vectors(2, &PairReport::friction_on_a);
  vectors(3, &PairReport::center);
  append_column<std::int32_t>(pairs.columns[4], room, list, 1,
                              [](const PairReport& r, std::int32_t* x) { *x = r.contacts; });
  append_column<double>(pairs.columns[5], room, list, 1, [](const PairReport& r, double* x) { *x = r.worst_overlap; });
  append_column<double>(pairs.columns[6], room, list, 1, [](const PairReport& r, double* x) { *x = r.worst_pressure; });
  pairs.close_frame(static_cast<std::int64_t>(list.size()));
}

void RunWriter::Impl::add_links(const std::vector<LinkReport>& list) {
  if (!links) return;
  append_column<double>(links->columns[0], room, list, 3, [](const LinkReport& r, double* x) {
    for (int a = 0; a < 3; ++a) x[a] = r.force[a];
  });
  append_column<double>(links->columns[1], room, list, 1, [](const LinkReport& r, double* x) { *x = r.error; });
  append_column<double>(links->columns[2], room, list, 1, [](const LinkReport& r, double* x) { *x = r.coordinate; });
  append_column<double>(links->columns[3], room, list, 1, [](const LinkReport& r, double* x) { *x = r.effort; });
  append_column<std::int32_t>(links->columns[4], room, list, 1,
                              [](const LinkReport& r, std::int32_t* x) { *x = r.broken ? 1 : 0; });
  links->close_frame(static_cast<std::int64_t>(list.size()));
}

void RunWriter::Impl::add_warnings(const std::vector<Warning>& list) {
  std::string text;
  for (const Warning& w : list)
    text += nlohmann::ordered_json{{"time", w.time}, {"code", w.code}, {"message", w.message}}.dump(
                -1, ' ', false, nlohmann::json::error_handler_t::replace) +
            "\n";
  warnings.columns[0].append(text.data(), text.size());
  warnings.close_frame(static_cast<std::int64_t>(text.size()));
}

/// Rows first, then how many frames are whole: a reader of what a killed process left never sees half a frame.
void RunWriter::Impl::flush() {
  const Clock::time_point start = Clock::now();
  for_each_column([](Column& c, const Ragged*) { c.flush(); });
  if (still_changed) still_set.overwrite(still.data(), Type::Int64);
  still_changed = false;
  file->flush();
  const auto frames = static_cast<std::int64_t>(times.size());
  count.overwrite(&frames, Type::Int64);
  file->flush();
  flush_cost = seconds_since(start);
  last_flush = Clock::now();
}

void RunWriter::Impl::write_xdmf() {
  const Clock::time_point start = Clock::now();
  write_whole((fs::path(folder) / "run.xdmf").string(), xdmf_text(xdmf, times));
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
  impl_->file = std::make_unique<h5::File>((fs::path(folder) / "run.h5").string(), h5::File::Mode::Write);
  impl_->mark_writer();
  impl_->open_all(world, false);
  impl_->cut_all(frame + 1);
}

RunWriter::~RunWriter() = default;
RunWriter::RunWriter(RunWriter&&) noexcept = default;

std::int64_t RunWriter::frames() const { return static_cast<std::int64_t>(impl_->times.size()); }

void RunWriter::add(const World& world, const StepReport& frame, int steps, std::span<const BodySample> samples) {
  add(world, frame, steps, samples, world.contacts(), world.active_tiles());
}

void RunWriter::add(const World& world, const StepReport& frame, int steps, std::span<const BodySample> samples,
                    std::span<const ContactSample> contacts, std::span<const std::pair<TileKey, double>> tiles) {
  Impl& d = *impl_;
  const State& state = world.state();
  const bool first = d.times.empty();
  d.time.append_value(state.time);
  d.step.append_value(state.step);
  d.q.append(state.q.data(), 1);
  d.v.append(state.v.data(), 1);
  d.add_series(frame, steps, samples);
  d.add_display(world);
  d.add_contacts(contacts);
  d.add_tiles(tiles);
  d.add_pairs(frame.pairs);
  d.add_links(frame.links);
  d.memory.columns[0].append(state.memory.data(), state.memory.size());
  d.memory.close_frame(static_cast<std::int64_t>(state.memory.size()));
  d.add_warnings(frame.warnings);
  d.times.push_back(state.time);
  // Slow frames are flushed one by one; fast ones together, so that flushing stays a small part of the time.
  if (first || seconds_since(d.last_flush) > std::min(kFlushSeconds, d.flush_cost / kFlushShare)) d.flush();
  if (first || seconds_since(d.last_xdmf) > std::max(kXdmfSeconds, d.xdmf_cost / kXdmfShare)) {
    d.flush();
    d.write_xdmf();
  }
}

void RunWriter::flush() {
  impl_->flush();
  impl_->write_xdmf();
}

}  // namespace brim
