#include "brim/record/run_reader.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <unordered_map>

#include "brim/body/posed_display.h"
#include "brim/record/h5.h"
#include "brim/record/run_layout.h"
#include "brim/world/report_fields.h"

namespace brim {

namespace fs = std::filesystem;
using h5::Type;
using Row = std::vector<std::uint64_t>;

namespace {

/// A pipe would be waited for, for ever.
std::string need_regular(const std::string& file) {
  std::error_code error;
  if (fs::exists(file, error) && !fs::is_regular_file(file, error))
    throw InputError(fmt::format("{}: is not a regular file; it must be a run.h5", file));
  return file;
}

std::string file_of(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) {
    const std::string file = (fs::path(path) / "run.h5").string();
    if (!fs::exists(file, error))
      throw InputError(fmt::format("{}: holds no run.h5; it must be the folder of a run", path));
    return need_regular(file);
  }
  return need_regular(path);
}

constexpr double kMostFrameTime = 1e9;  // [s]
constexpr std::int64_t kMostSteps = std::int64_t{1} << 30;

}  // namespace

struct RunReader::Impl {
  std::string path;
  h5::File file;
  std::string scene, version, scene_path;
  int format = 0;
  ProcessMark writer;
  double frame_time = 0.0;
  int steps_per_frame = 1;
  std::int64_t frames = 0;
  RunTables tables;
  std::vector<std::int64_t> still;                            ///< version 2, shape (bodies)
  mutable std::unordered_map<std::string, h5::Dataset> sets;  ///< open ones
  /// The rows of the frame that was asked for last: displays are asked for body by body.
  struct Rows {
    std::int64_t frame = -1;
    std::vector<double> rotation, translation;
    std::vector<float> positions;
  };
  mutable Rows rows_now;

  explicit Impl(const std::string& p) : path(p), file(p, h5::File::Mode::Read) {}

  std::uint64_t need(std::int64_t frame) const {
    if (frame < 0 || frame >= frames)
      throw InputError(fmt::format("{}: frame {} is not there; it must be from 0 to {}", path, frame, frames - 1));
    return static_cast<std::uint64_t>(frame);
  }
  std::size_t need_body(int body) const {
    if (body < 0 || static_cast<std::size_t>(body) >= tables.bodies.size())
      throw InputError(fmt::format("{}: body {} is not there; it must be from 0 to {}", path, body,
                                   static_cast<std::int64_t>(tables.bodies.size()) - 1));
    return static_cast<std::size_t>(body);
  }
  const h5::Dataset& set(const std::string& name) const {
    const auto it = sets.find(name);
    return it != sets.end() ? it->second : sets.emplace(name, file.open(name)).first->second;
  }
  /// @param row  extents after the first
  template <class T>
  std::vector<T> rows(const std::string& name, std::uint64_t first, std::uint64_t count,
                      const std::vector<std::uint64_t>& row, Type type) const {
    if (count == 0) return {};
    const h5::Dataset& s = set(name);
    s.need_rows(first, count, row);
    std::uint64_t width = 1;
    for (const std::uint64_t n : row) width *= n;
    std::vector<T> data(count * width);
    if (!data.empty()) s.read(data.data(), data.size(), first, count, type);
    return data;
  }
  template <class T>
  std::vector<T> rows(const std::string& name, std::uint64_t first, std::uint64_t count, std::size_t width,
                      Type type) const {
    return rows<T>(name, first, count, width == 1 ? Row{} : Row{width}, type);
  }
  /// The lines of a text that an older run may not have.
  std::vector<std::string> lines_of(const char* group, const char* attribute) const {
    std::vector<std::string> lines;
    if (!file.exists(group) || !file.has_attribute(group, attribute)) return lines;
    std::istringstream text(file.text(group, attribute));
    for (std::string line; std::getline(text, line);) lines.push_back(line);
    return lines;
  }
  /// Rows of a frame in a ragged list.
  std::pair<std::uint64_t, std::uint64_t> range(const std::string& group, std::int64_t frame) const {
    const auto o = rows<std::int64_t>(group + "/offset", need(frame), 2, 1, Type::Int64);
    if (o[0] < 0 || o[1] < o[0])
      throw InputError(
          fmt::format("{}:{}/offset: goes from {} to {} at frame {}; it must rise", path, group, o[0], o[1], frame));
    return {static_cast<std::uint64_t>(o[0]), static_cast<std::uint64_t>(o[1] - o[0])};
  }
  /// Scalars of some frames. Zeros for one of today's names that the run, being older, does not have.
  std::vector<double> scalars(const std::string& name, std::uint64_t first, std::uint64_t count) const {
    const std::string at = "/series/" + name;
    const auto today = [&](const ReportField& f) { return name == f.name; };
    if (!sets.contains(at) && !file.exists(at) && std::ranges::any_of(report_fields(), today))
      return std::vector<double>(count, 0.0);
    return rows<double>(at, first, count, 1, Type::Float64);
  }
  /// Part numbers of contacts and pairs, which are used as indices.
  std::vector<std::int32_t> parts_of(const std::string& name, std::uint64_t first, std::uint64_t n) const {
    const auto parts = rows<std::int32_t>(name, first, n, 2, Type::Int32);
    for (const std::int32_t p : parts)
      if (p < 0 || static_cast<std::size_t>(p) >= tables.parts.size())
        throw InputError(fmt::format("{}:{}: names part {}; it must be from 0 to {}", path, name, p,
                                     static_cast<std::int64_t>(tables.parts.size()) - 1));
    return parts;
  }
  const Rows& rows_of(std::int64_t frame) const;
  std::vector<Vec3f> placed(std::size_t body, std::int64_t frame) const;
  void read_head();
  void count_frames();
  void check_slices() const;
};

void RunReader::Impl::read_head() {
  if (!file.has_attribute("/", "format") || file.text("/", "format") != run_layout::kFormat)
    throw InputError(fmt::format("{}: is an HDF5 file but not a brim run; its attribute \"format\" must be \"{}\"",
                                 path, run_layout::kFormat));
  const double known = file.number("/", "version");
  if (!(known >= run_layout::kFirstVersion && known <= run_layout::kVersion))
    throw InputError(fmt::format("{}: has version {} of the run format; this brim reads versions {} to {}", path, known,
                                 run_layout::kFirstVersion, run_layout::kVersion));
  format = static_cast<int>(known);
  scene = file.text("/", "scene");
  version = file.text("/", "brim_version");
  frame_time = file.number("/", "frame_time");
  if (!(frame_time >= 0.0 && frame_time <= kMostFrameTime))
    throw InputError(fmt::format("{}: has frames of {} s; it must be from 0 to {}", path, frame_time, kMostFrameTime));
  steps_per_frame = static_cast<int>(file.whole("/", "steps_per_frame", 1, kMostSteps));
  if (file.has_attribute("/", "scene_path")) scene_path = file.text("/", "scene_path");
  if (file.has_attribute("/", "writer_pid"))
    writer = {file.whole("/", "writer_pid", 0, std::int64_t{1} << 40), file.text("/", "writer_host"),
              file.text("/", "writer_started")};
}

void RunReader::Impl::count_frames() {
  const std::uint64_t held = std::min(set("/frames/time").shape()[0], set("/frames/v").shape()[0]);
  frames = static_cast<std::int64_t>(held);
  if (format == 1) return;
  const std::int64_t counted = rows<std::int64_t>("/frames/count", 0, 1, 1, Type::Int64)[0];
  if (counted < 0 || static_cast<std::uint64_t>(counted) > held)
    throw InputError(fmt::format("{}:/frames/count: is {}, but {} frames are there", path, counted, held));
  frames = counted;
}

/// Slices of bodies must lie within the rows that they are slices of.
void RunReader::Impl::check_slices() const {
  if (frames == 0) return;
  const auto width = [&](const char* name) {
    const std::vector<std::uint64_t> shape = set(name).shape();
    if (shape.size() != 2)
      throw InputError(fmt::format("{}:{}: has {} axes; it must have two", path, name, shape.size()));
    return shape[1];
  };
  // Runs that were written by hand may have bodies without coordinates and no list of them.
  const std::uint64_t nv = width("/frames/v"), nq = file.exists("/frames/q") ? width("/frames/q") : 0;
  for (const RecordedBody& b : tables.bodies)
    if (b.q_size > nq || b.q_offset > nq - b.q_size || b.v_size > nv || b.v_offset > nv - b.v_size)
      throw InputError(
          fmt::format("{}: body \"{}\" has coordinates {} + {} and velocities {} + {}, but there are {} and {}", path,
                      b.name, b.q_offset, b.q_size, b.v_offset, b.v_size, nq, nv));
}

const RunReader::Impl::Rows& RunReader::Impl::rows_of(std::int64_t frame) const {
  if (rows_now.frame == frame) return rows_now;
  const std::uint64_t f = need(frame);
  rows_now.frame = -1;
  const std::size_t pieces = tables.piece_mesh.size();
  rows_now.rotation = rows<double>("/poses/rotation", f, 1, Row{pieces, 9}, Type::Float64);
  rows_now.translation = rows<double>("/poses/translation", f, 1, Row{pieces, 3}, Type::Float64);
  rows_now.positions = rows<float>("/display/positions", f, 1, Row{tables.positions, 3}, Type::Float32);
  rows_now.frame = frame;
  return rows_now;
}

/// Display positions of a body that deforms or moves in rigid pieces (version 2).
std::vector<Vec3f> RunReader::Impl::placed(std::size_t body, std::int64_t frame) const {
  const Rows& row = rows_of(frame);
  const RunTables::Place& place = tables.places[body];
  std::vector<Vec3f> x(tables.bodies[body].display.vertices);
  if (place.pieces == 0) {
    const float* from = row.positions.data() + 3 * place.first_position;
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = Vec3f(from + 3 * i);
    return x;
  }
  std::size_t first = 0;
  for (std::size_t i = place.first_piece; i < place.first_piece + place.pieces; ++i) {
    const std::span<const Vec3> rest = tables.mesh(i);
    Pose pose;
    pose.rotation = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(&row.rotation[9 * i]);
    pose.translation = Vec3(&row.translation[3 * i]);
    place_vertices(rest, pose, std::span(x).subspan(first, rest.size()));
    first += rest.size();
  }
  return x;
}

RunReader::RunReader(const std::string& path) : impl_(std::make_unique<Impl>(file_of(path))) {
  Impl& d = *impl_;
  d.read_head();
  d.tables = d.format == 1 ? read_tables_v1(d.file) : read_tables(d.file);
  d.count_frames();
  d.check_slices();
  if (d.format == 1) return;
  d.still = d.rows<std::int64_t>("/bodies/still", 0, d.tables.bodies.size(), 1, Type::Int64);
}

RunReader::~RunReader() = default;
RunReader::RunReader(RunReader&&) noexcept = default;

const std::string& RunReader::path() const { return impl_->path; }
const std::string& RunReader::scene_name() const { return impl_->scene; }
const std::string& RunReader::brim_version() const { return impl_->version; }
int RunReader::format_version() const { return impl_->format; }
const std::string& RunReader::scene_path() const { return impl_->scene_path; }
const ProcessMark& RunReader::writer() const { return impl_->writer; }
double RunReader::frame_time() const { return impl_->frame_time; }
int RunReader::steps_per_frame() const { return impl_->steps_per_frame; }
std::int64_t RunReader::frames() const { return impl_->frames; }
const std::vector<RecordedBody>& RunReader::bodies() const { return impl_->tables.bodies; }
const std::vector<RecordedPart>& RunReader::parts() const { return impl_->tables.parts; }

double RunReader::time(std::int64_t frame) const {
  return impl_->rows<double>("/frames/time", impl_->need(frame), 1, 1, Type::Float64)[0];
}

State RunReader::state(std::int64_t frame) const {
  const Impl& d = *impl_;
  const std::uint64_t f = d.need(frame);
  const auto row = [&](const char* name) {
    const std::vector<std::uint64_t> shape = d.set(name).shape();
    return d.rows<double>(name, f, 1, Row(shape.begin() + 1, shape.end()), Type::Float64);
  };
  State s;
  s.time = time(frame);
  s.step = d.rows<std::int64_t>("/frames/step", f, 1, 1, Type::Int64)[0];
  s.q = row("/frames/q");
  s.v = row("/frames/v");
  const auto [first, count] = d.range("/memory", frame);
  s.warm_start = d.rows<double>("/memory/value", first, count, 1, Type::Float64);
  return s;
}

std::vector<Vec3f> RunReader::positions(int body, std::int64_t frame) const {
  const Impl& d = *impl_;
  const RecordedBody& b = d.tables.bodies[d.need_body(body)];
  if (b.changing) {
    const std::string at = fmt::format("/display/{}/vertices", body);
    const auto [first, n] = d.range(at, frame);
    const auto rows = d.rows<float>(at + "/position", first, n, 3, Type::Float32);
    std::vector<Vec3f> x(n);
    for (std::size_t i = 0; i < n; ++i) x[i] = Vec3f(&rows[3 * i]);
    return x;
  }
  d.need(frame);
  if (d.format > 1) return d.placed(static_cast<std::size_t>(body), frame);
  const std::string at = fmt::format("/display/{}/positions", body);
  const std::uint64_t held = d.set(at).shape()[0];
  if (held == 0) throw InputError(fmt::format("{}:{}: has no rows", d.path, at));
  // One row stands for all frames of a body that never moved.
  const std::uint64_t row = std::min(static_cast<std::uint64_t>(frame), held - 1);
  const auto numbers = d.rows<float>(at, row, 1, Row{b.display.vertices, 3}, Type::Float32);
  std::vector<Vec3f> x(b.display.vertices);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = Vec3f(&numbers[3 * i]);
  return x;
}

std::vector<Triangle> RunReader::triangles(int body, std::int64_t frame) const {
  const RecordedBody& b = impl_->tables.bodies[impl_->need_body(body)];
  if (!b.changing) return b.display.triangles;
  const std::string at = fmt::format("/display/{}/triangles", body);
  const auto [first, n] = impl_->range(at, frame);
  const auto rows = impl_->rows<std::int32_t>(at + "/corner", first, n, 3, Type::Int32);
  const std::uint64_t vertices = impl_->range(fmt::format("/display/{}/vertices", body), frame).second;
  std::vector<Triangle> list(n);
  for (std::size_t i = 0; i < n; ++i) list[i] = {rows[3 * i], rows[3 * i + 1], rows[3 * i + 2]};
  for (const std::int32_t corner : rows)
    if (corner < 0 || static_cast<std::uint64_t>(corner) >= vertices)
      throw InputError(
          fmt::format("{}:{}: names vertex {} of {} in frame {}", impl_->path, at, corner, vertices, frame));
  return list;
}

bool RunReader::still(int body) const {
  const std::size_t b = impl_->need_body(body);
  if (impl_->tables.bodies[b].changing) return false;
  if (impl_->format > 1) return impl_->still[b] != 0;
  return impl_->set(fmt::format("/display/{}/positions", body)).shape()[0] <= 1;
}

std::vector<ContactSample> RunReader::contacts(std::int64_t frame) const {
  const auto [first, n] = impl_->range("/contacts", frame);
  const auto x = impl_->rows<float>("/contacts/position", first, n, 3, Type::Float32);
  const auto f = impl_->rows<float>("/contacts/force", first, n, 3, Type::Float32);
  const auto t = impl_->rows<float>("/contacts/friction", first, n, 3, Type::Float32);
  const auto o = impl_->rows<float>("/contacts/overlap", first, n, 1, Type::Float32);
  const auto p = impl_->parts_of("/contacts/pair", first, n);
  std::vector<ContactSample> list(n);
  for (std::size_t i = 0; i < n; ++i)
    list[i] = {Vec3f(&x[3 * i]), Vec3f(&f[3 * i]), Vec3f(&t[3 * i]), o[i], p[2 * i], p[2 * i + 1]};
  return list;
}

std::vector<std::pair<TileKey, double>> RunReader::tiles(std::int64_t frame) const {
  const auto [first, n] = impl_->range("/tiles", frame);
  const auto k = impl_->rows<std::int32_t>("/tiles/key", first, n, 3, Type::Int32);
  const auto h = impl_->rows<double>("/tiles/step", first, n, 1, Type::Float64);
  std::vector<std::pair<TileKey, double>> list(n);
  for (std::size_t i = 0; i < n; ++i) list[i] = {TileKey{k[3 * i], k[3 * i + 1], k[3 * i + 2]}, h[i]};
  return list;
}

std::vector<PairReport> RunReader::pairs(std::int64_t frame) const {
  const auto [first, n] = impl_->range("/pairs", frame);
  const auto parts = impl_->parts_of("/pairs/parts", first, n);
  const auto force = impl_->rows<double>("/pairs/force", first, n, 3, Type::Float64);
  const auto friction = impl_->rows<double>("/pairs/friction", first, n, 3, Type::Float64);
  const auto center = impl_->rows<double>("/pairs/center", first, n, 3, Type::Float64);
  const auto contacts = impl_->rows<std::int32_t>("/pairs/contacts", first, n, 1, Type::Int32);
  const auto overlap = impl_->rows<double>("/pairs/overlap", first, n, 1, Type::Float64);
  const auto pressure = impl_->rows<double>("/pairs/pressure", first, n, 1, Type::Float64);
  std::vector<PairReport> list(n);
  for (std::size_t i = 0; i < n; ++i) {
    PairReport& r = list[i];
    r.part_a = parts[2 * i];
    r.part_b = parts[2 * i + 1];
    r.contacts = contacts[i];
    r.worst_overlap = overlap[i];
    r.worst_pressure = pressure[i];
    r.force_on_a = Vec3(&force[3 * i]);
    r.friction_on_a = Vec3(&friction[3 * i]);
    r.center = Vec3(&center[3 * i]);
  }
  return list;
}

std::vector<LinkReport> RunReader::links(std::int64_t frame) const {
  impl_->need(frame);
  if (!impl_->file.exists("/links")) return {};
  const auto [first, n] = impl_->range("/links", frame);
  const auto force = impl_->rows<double>("/links/force", first, n, 3, Type::Float64);
  const auto error = impl_->rows<double>("/links/error", first, n, 1, Type::Float64);
  const auto coordinate = impl_->rows<double>("/links/coordinate", first, n, 1, Type::Float64);
  const auto effort = impl_->rows<double>("/links/effort", first, n, 1, Type::Float64);
  const auto broken = impl_->rows<std::int32_t>("/links/broken", first, n, 1, Type::Int32);
  std::vector<LinkReport> list(n);
  for (std::size_t i = 0; i < n; ++i)
    list[i] = {Vec3(&force[3 * i]), error[i], coordinate[i], effort[i], broken[i] != 0};
  return list;
}

std::vector<std::string> RunReader::link_names() const { return impl_->lines_of("/links", "names"); }
std::vector<std::string> RunReader::link_kinds() const { return impl_->lines_of("/links", "kinds"); }

std::vector<std::pair<int, int>> RunReader::link_bodies() const {
  std::vector<std::pair<int, int>> list;
  const int n = static_cast<int>(impl_->tables.bodies.size());
  for (const std::string& line : impl_->lines_of("/links", "bodies")) {
    std::istringstream words(line);
    std::pair<int, int> both{-1, -1};
    if (!(words >> both.first >> both.second) || both.first < 0 || both.second < -1 ||
        std::max(both.first, both.second) >= n)
      throw InputError(fmt::format("{}: the bodies of its attachments are damaged: \"{}\"", impl_->path, line));
    list.push_back(both);
  }
  return list;
}

std::vector<RecordedEnd> RunReader::link_ends(std::int64_t frame) const {
  impl_->need(frame);
  if (!impl_->file.exists("/link_ends")) return {};
  const auto [first, n] = impl_->range("/link_ends", frame);
  const auto link = impl_->rows<std::int32_t>("/link_ends/link", first, n, 1, Type::Int32);
  const auto a = impl_->rows<float>("/link_ends/a", first, n, 3, Type::Float32);
  const auto b = impl_->rows<float>("/link_ends/b", first, n, 3, Type::Float32);
  std::vector<RecordedEnd> list(n);
  for (std::size_t i = 0; i < n; ++i) list[i] = {link[i], Vec3f(&a[3 * i]), Vec3f(&b[3 * i])};
  return list;
}

std::vector<Warning> RunReader::warnings(std::int64_t frame) const {
  const auto [first, n] = impl_->range("/warnings", frame);
  const auto bytes = impl_->rows<std::uint8_t>("/warnings/text", first, n, 1, Type::UInt8);
  std::istringstream lines(std::string(bytes.begin(), bytes.end()));
  std::vector<Warning> list;
  for (std::string line; std::getline(lines, line);) {
    const auto w = nlohmann::json::parse(line, nullptr, false);
    if (!w.is_object() || !w.contains("time") || !w["time"].is_number()) continue;
    const auto word = [&](const char* key) {
      return w.contains(key) && w[key].is_string() ? w[key].get<std::string>() : std::string();
    };
    list.push_back({w["time"].get<double>(), word("code"), word("message")});
  }
  return list;
}

StepReport RunReader::report(std::int64_t frame) const {
  StepReport r;
  for (const ReportField& f : report_fields()) f.set(r, impl_->scalars(f.name, impl_->need(frame), 1)[0]);
  r.time = time(frame);
  r.pairs = pairs(frame);
  r.links = links(frame);
  r.warnings = warnings(frame);
  return r;
}

int RunReader::steps(std::int64_t frame) const {
  const double steps = impl_->scalars("steps", impl_->need(frame), 1)[0];
  if (!(steps >= 0.0 && steps <= static_cast<double>(kMostSteps)))
    throw InputError(fmt::format("{}:/series/steps: is {} at frame {}", impl_->path, steps, frame));
  return static_cast<int>(steps);
}

std::vector<BodySample> RunReader::samples(std::int64_t frame) const {
  std::vector<BodySample> list(impl_->tables.bodies.size());
  for (const run_layout::MotionField& f : run_layout::kMotion) {
    const auto width = static_cast<std::size_t>(f.width);
    const auto x = impl_->rows<double>(f.path, impl_->need(frame), 1,
                                       width > 1 ? Row{list.size(), width} : Row{list.size()}, Type::Float64);
    for (std::size_t b = 0; b < list.size(); ++b) f.set(list[b], &x[b * width]);
  }
  return list;
}

std::vector<double> RunReader::series(const std::string& name) const {
  return impl_->scalars(name, 0, static_cast<std::uint64_t>(impl_->frames));
}

void check_same_world(const RunReader& run, const World& world) {
  const auto differ = [](const std::string& what) {
    throw InputError(fmt::format("the recorded run is of another scene: {}", what));
  };
  const std::vector<RecordedBody>& bodies = run.bodies();
  if (bodies.size() != static_cast<std::size_t>(world.body_count()))
    differ(fmt::format("it has {} bodies, the scene {}", bodies.size(), world.body_count()));
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const Body& body = world.body(static_cast<int>(b));
    if (bodies[b].name != body.name() || bodies[b].kind != body.kind())
      differ(fmt::format("body {} is \"{}\" ({}), in the scene \"{}\" ({})", b, bodies[b].name, bodies[b].kind,
                         body.name(), body.kind()));
    if (bodies[b].q_size != body.q_size() || bodies[b].v_size != body.v_size() ||
        bodies[b].display.vertices != body.display().vertices)
      differ(fmt::format("body \"{}\" has {} coordinates and {} vertices, in the scene {} and {}", body.name(),
                         bodies[b].q_size, bodies[b].display.vertices, body.q_size(), body.display().vertices));
  }
}

}  // namespace brim
