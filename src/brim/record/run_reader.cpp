#include "brim/record/run_reader.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <unordered_map>

#include "brim/body/posed_display.h"
#include "brim/record/h5.h"
#include "brim/record/run_layout.h"
#include "brim/record/run_reader_impl.h"
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

}  // namespace

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

std::vector<RecordedPiece> RunReader::pieces(int body) const {
  const Impl& d = *impl_;
  const std::size_t b = d.need_body(body);
  std::vector<RecordedPiece> list;
  if (d.format == 1) return list;
  const RunTables::Place& place = d.tables.places[b];
  for (std::size_t i = place.first_piece; i < place.first_piece + place.pieces; ++i)
    list.push_back({list.empty() ? 0 : list.back().first_vertex + list.back().vertices, d.tables.mesh(i).size()});
  return list;
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
