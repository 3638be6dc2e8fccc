#include "brim/record/run_reader.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "brim/record/h5.h"
#include "brim/record/run_layout.h"
#include "brim/world/report_fields.h"

namespace brim {

namespace fs = std::filesystem;
using h5::Type;

namespace {

std::string file_of(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) {
    const std::string file = (fs::path(path) / "run.h5").string();
    if (!fs::exists(file, error))
      throw InputError(fmt::format("{}: holds no run.h5; it must be the folder of a run", path));
    return file;
  }
  return path;
}

Display::Kind display_kind(const std::string& word) {
  if (word == "triangles") return Display::Kind::Triangles;
  if (word == "lines") return Display::Kind::Lines;
  return Display::Kind::Points;
}

}  // namespace

struct RunReader::Impl {
  std::string path;
  h5::File file;
  std::string scene, version, scene_path;
  ProcessMark writer;
  double frame_time = 0.0;
  int steps_per_frame = 1;
  std::int64_t frames = 0;
  std::vector<RecordedBody> bodies;
  std::vector<RecordedPart> parts;

  explicit Impl(const std::string& p) : path(p), file(p, h5::File::Mode::Read) {}

  std::uint64_t need(std::int64_t frame) const {
    if (frame < 0 || frame >= frames)
      throw InputError(fmt::format("{}: frame {} is not there; it must be from 0 to {}", path, frame, frames - 1));
    return static_cast<std::uint64_t>(frame);
  }
  template <class T>
  std::vector<T> rows(const std::string& name, std::uint64_t first, std::uint64_t count, std::size_t width,
                      Type type) const {
    std::vector<T> data(count * width);
    if (!data.empty()) file.open(name).read(data.data(), first, count, type);
    return data;
  }
  /// Rows of a frame in a ragged list.
  std::pair<std::uint64_t, std::uint64_t> range(const std::string& group, std::int64_t frame) const {
    const auto o = rows<std::int64_t>(group + "/offset", need(frame), 2, 1, Type::Int64);
    return {static_cast<std::uint64_t>(o[0]), static_cast<std::uint64_t>(o[1] - o[0])};
  }
  /// Scalars of some frames. Zeros for one of today's names that the run, being older, does not have.
  std::vector<double> scalars(const std::string& name, std::uint64_t first, std::uint64_t count) const {
    const std::string set = "/series/" + name;
    const auto today = [&](const ReportField& f) { return name == f.name; };
    if (!file.exists(set) && std::ranges::any_of(report_fields(), today)) return std::vector<double>(count, 0.0);
    return rows<double>(set, first, count, 1, Type::Float64);
  }
  void read_bodies();
  void read_parts();
};

void RunReader::Impl::read_bodies() {
  for (int b = 0;; ++b) {
    const std::string at = "/bodies/" + std::to_string(b);
    if (!file.exists(at)) return;
    const auto whole = [&](const char* name) { return static_cast<std::size_t>(file.number(at, name)); };
    RecordedBody body;
    body.name = file.text(at, "name");
    body.kind = file.text(at, "kind");
    body.display.kind = display_kind(file.text(at, "display_kind"));
    body.display.two_sided = whole("two_sided") != 0;
    body.display.radius = file.number(at, "radius");
    body.display.vertices = whole("vertices");
    body.immobile = whole("immobile") != 0;
    body.changing = file.has_attribute(at, "changing") && whole("changing") != 0;
    body.mass = file.number(at, "mass");
    body.q_offset = whole("q_offset");
    body.q_size = whole("q_size");
    body.v_offset = whole("v_offset");
    body.v_size = whole("v_size");
    body.parts = static_cast<int>(whole("parts"));
    if (body.display.kind == Display::Kind::Triangles && !body.changing) {
      const h5::Dataset set = file.open(at + "/triangles");
      body.display.triangles.resize(set.shape()[0]);
      set.read(body.display.triangles.data(), 0, set.shape()[0], Type::Int32);
    } else if (body.display.kind == Display::Kind::Lines) {
      const h5::Dataset set = file.open(at + "/lines");
      body.display.lines.resize(set.shape()[0]);
      set.read(body.display.lines.data(), 0, set.shape()[0], Type::Int32);
    }
    bodies.push_back(std::move(body));
  }
}

void RunReader::Impl::read_parts() {
  for (int p = 0;; ++p) {
    const std::string at = "/parts/" + std::to_string(p);
    if (!file.exists(at)) return;
    parts.push_back({file.text(at, "name"), file.text(at, "material"), static_cast<int>(file.number(at, "body")),
                     static_cast<int>(file.number(at, "part")), file.number(at, "voxel_size")});
  }
}

RunReader::RunReader(const std::string& path) : impl_(std::make_unique<Impl>(file_of(path))) {
  Impl& d = *impl_;
  if (!d.file.has_attribute("/", "format") || d.file.text("/", "format") != run_layout::kFormat)
    throw InputError(fmt::format("{}: is an HDF5 file but not a brim run; its attribute \"format\" must be \"{}\"",
                                 d.path, run_layout::kFormat));
  const int version = static_cast<int>(d.file.number("/", "version"));
  if (version != run_layout::kVersion)
    throw InputError(fmt::format("{}: has version {} of the run format; this brim reads version {}", d.path, version,
                                 run_layout::kVersion));
  d.scene = d.file.text("/", "scene");
  d.version = d.file.text("/", "brim_version");
  d.frame_time = d.file.number("/", "frame_time");
  d.steps_per_frame = static_cast<int>(d.file.number("/", "steps_per_frame"));
  if (d.file.has_attribute("/", "scene_path")) d.scene_path = d.file.text("/", "scene_path");
  if (d.file.has_attribute("/", "writer_pid"))
    d.writer = {static_cast<std::int64_t>(d.file.number("/", "writer_pid")), d.file.text("/", "writer_host"),
                d.file.text("/", "writer_started")};
  d.read_bodies();
  d.read_parts();
  d.frames =
      static_cast<std::int64_t>(std::min(d.file.open("/frames/time").shape()[0], d.file.open("/frames/v").shape()[0]));
}

RunReader::~RunReader() = default;
RunReader::RunReader(RunReader&&) noexcept = default;

const std::string& RunReader::path() const { return impl_->path; }
const std::string& RunReader::scene_name() const { return impl_->scene; }
const std::string& RunReader::brim_version() const { return impl_->version; }
const std::string& RunReader::scene_path() const { return impl_->scene_path; }
const ProcessMark& RunReader::writer() const { return impl_->writer; }
double RunReader::frame_time() const { return impl_->frame_time; }
int RunReader::steps_per_frame() const { return impl_->steps_per_frame; }
std::int64_t RunReader::frames() const { return impl_->frames; }
const std::vector<RecordedBody>& RunReader::bodies() const { return impl_->bodies; }
const std::vector<RecordedPart>& RunReader::parts() const { return impl_->parts; }

double RunReader::time(std::int64_t frame) const {
  return impl_->rows<double>("/frames/time", impl_->need(frame), 1, 1, Type::Float64)[0];
}

State RunReader::state(std::int64_t frame) const {
  const Impl& d = *impl_;
  const std::uint64_t f = d.need(frame);
  State s;
  s.time = time(frame);
  s.step = d.rows<std::int64_t>("/frames/step", f, 1, 1, Type::Int64)[0];
  s.q = d.rows<double>("/frames/q", f, 1, d.file.open("/frames/q").shape()[1], Type::Float64);
  s.v = d.rows<double>("/frames/v", f, 1, d.file.open("/frames/v").shape()[1], Type::Float64);
  const auto [first, count] = d.range("/memory", frame);
  s.memory = d.rows<double>("/memory/value", first, count, 1, Type::Float64);
  return s;
}

std::vector<Vec3f> RunReader::positions(int body, std::int64_t frame) const {
  const Impl& d = *impl_;
  if (body < 0 || static_cast<std::size_t>(body) >= d.bodies.size())
    throw InputError(
        fmt::format("{}: body {} is not there; it must be from 0 to {}", d.path, body, d.bodies.size() - 1));
  if (d.bodies[static_cast<std::size_t>(body)].changing) {
    const std::string at = fmt::format("/display/{}/vertices", body);
    const auto [first, n] = d.range(at, frame);
    const auto rows = d.rows<float>(at + "/position", first, n, 3, Type::Float32);
    std::vector<Vec3f> x(n);
    for (std::size_t i = 0; i < n; ++i) x[i] = Vec3f(&rows[3 * i]);
    return x;
  }
  const h5::Dataset set = d.file.open(fmt::format("/display/{}/positions", body));
  std::vector<Vec3f> x(d.bodies[static_cast<std::size_t>(body)].display.vertices);
  // One row stands for all frames of a body that never moved.
  const std::uint64_t row = std::min(d.need(frame), set.shape()[0] - 1);
  if (!x.empty()) set.read(x.data(), row, 1, Type::Float32);
  return x;
}

std::vector<Triangle> RunReader::triangles(int body, std::int64_t frame) const {
  const RecordedBody& b = impl_->bodies.at(static_cast<std::size_t>(body));
  if (!b.changing) return b.display.triangles;
  const std::string at = fmt::format("/display/{}/triangles", body);
  const auto [first, n] = impl_->range(at, frame);
  const auto rows = impl_->rows<std::int32_t>(at + "/corner", first, n, 3, Type::Int32);
  std::vector<Triangle> list(n);
  for (std::size_t i = 0; i < n; ++i) list[i] = {rows[3 * i], rows[3 * i + 1], rows[3 * i + 2]};
  return list;
}

bool RunReader::still(int body) const {
  if (impl_->bodies.at(static_cast<std::size_t>(body)).changing) return false;
  return impl_->file.open(fmt::format("/display/{}/positions", body)).shape()[0] <= 1;
}

std::vector<ContactSample> RunReader::contacts(std::int64_t frame) const {
  const auto [first, n] = impl_->range("/contacts", frame);
  const auto x = impl_->rows<float>("/contacts/position", first, n, 3, Type::Float32);
  const auto f = impl_->rows<float>("/contacts/force", first, n, 3, Type::Float32);
  const auto t = impl_->rows<float>("/contacts/friction", first, n, 3, Type::Float32);
  const auto o = impl_->rows<float>("/contacts/overlap", first, n, 1, Type::Float32);
  const auto p = impl_->rows<std::int32_t>("/contacts/pair", first, n, 2, Type::Int32);
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
  const auto parts = impl_->rows<std::int32_t>("/pairs/parts", first, n, 2, Type::Int32);
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

std::vector<Warning> RunReader::warnings(std::int64_t frame) const {
  const auto [first, n] = impl_->range("/warnings", frame);
  const auto bytes = impl_->rows<std::uint8_t>("/warnings/text", first, n, 1, Type::UInt8);
  std::istringstream lines(std::string(bytes.begin(), bytes.end()));
  std::vector<Warning> list;
  for (std::string line; std::getline(lines, line);) {
    const auto w = nlohmann::json::parse(line, nullptr, false);
    if (w.is_object()) list.push_back({w.value("time", 0.0), w.value("code", ""), w.value("message", "")});
  }
  return list;
}

StepReport RunReader::report(std::int64_t frame) const {
  StepReport r;
  for (const ReportField& f : report_fields()) f.set(r, impl_->scalars(f.name, impl_->need(frame), 1)[0]);
  r.time = time(frame);
  r.pairs = pairs(frame);
  r.warnings = warnings(frame);
  return r;
}

int RunReader::steps(std::int64_t frame) const {
  return static_cast<int>(impl_->scalars("steps", impl_->need(frame), 1)[0]);
}

std::vector<BodySample> RunReader::samples(std::int64_t frame) const {
  std::vector<BodySample> list(impl_->bodies.size());
  for (const run_layout::MotionField& f : run_layout::kMotion) {
    const auto width = static_cast<std::size_t>(f.width);
    const auto x = impl_->rows<double>(f.path, impl_->need(frame), 1, list.size() * width, Type::Float64);
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
