#include "server/recorded_run.h"

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <thread>

#include "brim/body/stressed_solid.h"
#include "brim/core/error.h"
#include "brim/io/regular_file.h"
#include "brim/record/sensor_record.h"
#include "brim/world/report_fields.h"
#include "server/array_message.h"

namespace brim::viewer {

namespace fs = std::filesystem;
using Json = nlohmann::json;

namespace {

constexpr std::size_t kWarningsShown = 1000;
constexpr double kSilence = 600.0;  // [s]
constexpr int kAttempts = 4;
constexpr int kMostAsked = 3;  // fewer than HttpServer has threads
constexpr int kFirstAttempts = 25;
constexpr auto kPause = std::chrono::milliseconds(40);

const char* display_word(Display::Kind kind) {
  switch (kind) {
    case Display::Kind::Triangles:
      return "triangles";
    case Display::Kind::Lines:
      return "lines";
    case Display::Kind::Points:
      return "points";
  }
  return "points";
}

/// Totals of the touching pairs of parts.
void add_pairs(const std::vector<PairReport>& pairs, ArrayMessage& message) {
  std::vector<std::int32_t> parts, contacts;
  std::vector<float> normal, friction, overlap, pressure;
  for (const PairReport& p : pairs) {
    parts.insert(parts.end(), {p.part_a, p.part_b});
    contacts.push_back(p.contacts);
    normal.push_back(static_cast<float>((p.force_on_a - p.friction_on_a).norm()));
    friction.push_back(static_cast<float>(p.friction_on_a.norm()));
    overlap.push_back(static_cast<float>(p.worst_overlap));
    pressure.push_back(static_cast<float>(p.worst_pressure));
  }
  message.add("pairs/parts", parts.data(), pairs.size(), 2);
  message.add("pairs/contacts", contacts.data(), pairs.size());
  message.add("pairs/normal", normal.data(), pairs.size());
  message.add("pairs/friction", friction.data(), pairs.size());
  message.add("pairs/overlap", overlap.data(), pairs.size());
  message.add("pairs/pressure", pressure.data(), pairs.size());
}

/// Where attachments and joints have their ends.
void add_link_ends(const std::vector<RecordedEnd>& ends, ArrayMessage& message) {
  std::vector<std::int32_t> link;
  std::vector<float> a, b;
  for (const RecordedEnd& e : ends) {
    link.push_back(e.link);
    a.insert(a.end(), e.a.data(), e.a.data() + 3);
    b.insert(b.end(), e.b.data(), e.b.data() + 3);
  }
  message.add("links/link", link.data(), ends.size());
  message.add("links/a", a.data(), ends.size(), 3);
  message.add("links/b", b.data(), ends.size(), 3);
}

bool same_process(const ProcessMark& a, const ProcessMark& b) {
  return a.pid == b.pid && a.host == b.host && a.started == b.started;
}

Json read_json(const fs::path& path) {
  const std::optional<std::string> text = read_regular_file(path.string());
  Json value = text ? Json::parse(*text, nullptr, false) : Json::object();
  return value.is_discarded() ? Json::object() : value;
}

std::string message_of(const DensitySlice& s) {
  ArrayMessage message;
  const double plane[] = {static_cast<double>(s.axis), s.at, s.step, s.lowest, s.highest};
  const std::int32_t nodes[] = {s.first[0], s.first[1], s.count[0], s.count[1]};
  const auto rows = static_cast<std::size_t>(s.count[1]), columns = static_cast<std::size_t>(s.count[0]);
  message.add("plane", plane, 5);
  message.add("nodes", nodes, 4);
  message.add("density", s.density.data(), rows, columns);
  message.add("body", s.body.data(), rows, columns);
  message.add("second", s.second.data(), rows, columns);
  message.add("second_body", s.second_body.data(), rows, columns);
  message.add("overlap", s.overlap.data(), rows, columns);
  return message.bytes();
}

}  // namespace

RecordedRun::RecordedRun(const std::string& path) {
  folder_ = fs::is_directory(path) ? fs::path(path) : fs::path(path).parent_path();
  file_ = fs::is_directory(path) ? folder_ / "run.h5" : fs::path(path);
  // A file caught in the middle of a write is tried again; the last message is better than any made here.
  for (int attempt = 0;; ++attempt) {
    try {
      [[maybe_unused]] const RunReader readable(path);
      break;
    } catch (const InputError&) {
      if (attempt == kFirstAttempts || !fs::is_regular_file(file_)) throw;
      std::this_thread::sleep_for(kPause);
    }
  }
  refresh();
}

void RecordedRun::refresh() {
  std::error_code error;
  const auto now = fs::last_write_time(file_, error);
  if (reader_ && (error || now == seen_)) return;
  // HDF5 hands an open file's old view to whoever opens it again in the same process, so it must be closed first. A
  // file caught in the middle of a write is tried again.
  const std::int64_t before = progress_.frames;
  reader_.reset();
  for (int attempt = 0;; ++attempt) {
    try {
      reader_ = std::make_unique<RunReader>(file_.string());
      break;
    } catch (const InputError&) {
      if (attempt == kAttempts) throw;
      std::this_thread::sleep_for(kPause);
    }
  }
  seen_ = now;
  progress_.frames = reader_->frames();
  // The run may have been started anew, with other bodies in as many frames.
  if (progress_.frames < before || !same_process(reader_->writer(), writer_)) {
    warnings_.clear();
    warnings_read_ = 0;
    world_stale_ = true;
  }
  writer_ = reader_->writer();
}

bool RecordedRun::fixed(std::size_t body) const {
  return reader_->bodies()[body].immobile && reader_->still(static_cast<int>(body));
}

void RecordedRun::find_end(Progress& progress) const {
  // The summary is written when a run ends; one that speaks of fewer frames is of a run since gone on with.
  const Json summary = read_json(folder_ / "summary.json");
  const bool ended = summary.is_object() && summary.contains("frames") && summary["frames"].is_number_integer() &&
                     summary["frames"].get<std::int64_t>() == progress_.frames;
  progress.stopped = !ended && writer_gone();
  progress.complete = ended || progress.stopped;
}

bool RecordedRun::writer_gone() const {
  switch (state_of(reader_->writer())) {
    case ProcessState::Running:
      return false;
    case ProcessState::Gone:
      return true;
    case ProcessState::Unknown:
      break;
  }
  // Of another machine, or of a version that left no mark: silence tells, measured by the pace of the frames so far.
  const double silent = std::chrono::duration<double>(fs::file_time_type::clock::now() - seen_).count();
  double pace = 0.0;
  const std::vector<double> wall = reader_->series("wall");
  for (const double seconds : wall) pace = std::max(pace, seconds);
  return silent > std::max(kSilence, 20.0 * pace);
}

Progress RecordedRun::progress() {
  const std::lock_guard lock(mutex_);
  try {
    refresh();
    find_end(progress_);
  } catch (const InputError&) {
    // The file cannot be read at the moment: nothing new is known.
  }
  return progress_;
}

Json RecordedRun::info() {
  const std::lock_guard lock(mutex_);
  refresh();
  Json bodies = Json::array();
  const auto& list = reader_->bodies();
  for (std::size_t b = 0; b < list.size(); ++b)
    bodies.push_back({{"index", b},
                      {"name", list[b].name},
                      {"kind", list[b].kind},
                      {"display", display_word(list[b].display.kind)},
                      {"twoSided", list[b].display.two_sided},
                      {"radius", list[b].display.radius},
                      {"vertices", list[b].display.vertices},
                      {"changing", list[b].changing},
                      {"fixed", fixed(b)},
                      {"parts", Json::array()}});
  Json parts = Json::array();
  for (std::size_t p = 0; p < reader_->parts().size(); ++p) {
    const RecordedPart& part = reader_->parts()[p];
    const auto body = static_cast<std::size_t>(part.body);
    parts.push_back({{"name", part.name}, {"body", part.body}, {"voxelSize", part.voxel_size}});
    if (body < list.size()) bodies[body]["parts"].push_back(p);
  }
  for (; warnings_read_ < reader_->frames() && warnings_.size() < kWarningsShown; ++warnings_read_)
    for (Warning& w : reader_->warnings(warnings_read_)) warnings_.push_back(std::move(w));
  Json sensors = Json::array();
  const SensorRecord record(*reader_);
  for (const RecordedSensor& sensor : record.sensors())
    sensors.push_back(
        {{"name", sensor.name}, {"kind", sensor.kind}, {"channels", sensor.channels}, {"units", sensor.units}});
  Json links = Json::array();
  const std::vector<std::string> link_names = reader_->link_names(), link_kinds = reader_->link_kinds();
  for (std::size_t i = 0; i < std::min(link_names.size(), link_kinds.size()); ++i)
    links.push_back({{"name", link_names[i]}, {"kind", link_kinds[i]}});
  const std::vector<std::pair<int, int>> link_bodies = reader_->link_bodies();
  for (std::size_t i = 0; i < std::min(links.size(), link_bodies.size()); ++i)
    links[i]["bodies"] = {link_bodies[i].first, link_bodies[i].second};
  Json warnings = Json::array();
  for (const Warning& w : warnings_) warnings.push_back({{"time", w.time}, {"code", w.code}, {"message", w.message}});
  Progress end;
  find_end(end);
  const std::string folder_name = fs::absolute(folder_).lexically_normal().filename().string();
  return {{"name", folder_name.empty() ? reader_->scene_name() : folder_name},
          {"scene", reader_->scene_name()},
          {"brimVersion", reader_->brim_version()},
          {"frames", reader_->frames()},
          {"complete", end.complete},
          {"stopped", end.stopped},
          {"slices", fs::exists(folder_ / "scene.json")},
          {"bodies", bodies},
          {"parts", parts},
          {"warnings", warnings},
          {"sensors", sensors},
          {"links", links},
          {"summary", read_json(folder_ / "summary.json")}};
}

std::string RecordedRun::topology(int body) {
  const std::lock_guard lock(mutex_);
  if (!reader_) refresh();
  if (body < 0 || static_cast<std::size_t>(body) >= reader_->bodies().size())
    throw InputError(fmt::format("no body {}", body));
  const RecordedBody& b = reader_->bodies()[static_cast<std::size_t>(body)];
  ArrayMessage message;
  if (b.display.kind == Display::Kind::Triangles && !b.changing)
    message.add("triangles", reinterpret_cast<const std::int32_t*>(b.display.triangles.data()),
                b.display.triangles.size(), 3, body);
  if (b.display.kind == Display::Kind::Lines)
    message.add("lines", reinterpret_cast<const std::int32_t*>(b.display.lines.data()), b.display.lines.size(), 2,
                body);
  if (fixed(static_cast<std::size_t>(body)) && reader_->frames() > 0) {
    const std::vector<Vec3f> x = reader_->positions(body, 0);
    message.add("positions", reinterpret_cast<const float*>(x.data()), x.size(), 3, body);
  }
  return message.bytes();
}

std::string RecordedRun::frame(std::int64_t frame) {
  const std::lock_guard lock(mutex_);
  if (!reader_ || frame >= reader_->frames()) refresh();
  ArrayMessage message;
  const double time = reader_->time(frame);
  message.add("time", &time, 1);
  const std::vector<std::int32_t> removed = reader_->removed(frame);
  message.add("removed", removed.data(), removed.size());
  for (std::size_t b = 0; b < reader_->bodies().size(); ++b) {
    if (fixed(b) || std::ranges::binary_search(removed, static_cast<std::int32_t>(b))) continue;
    const std::vector<Vec3f> x = reader_->positions(static_cast<int>(b), frame);
    message.add("positions", reinterpret_cast<const float*>(x.data()), x.size(), 3, static_cast<int>(b));
    if (!reader_->bodies()[b].changing) continue;
    const std::vector<Triangle> triangles = reader_->triangles(static_cast<int>(b), frame);
    message.add("triangles", reinterpret_cast<const std::int32_t*>(triangles.data()), triangles.size(), 3,
                static_cast<int>(b));
  }
  const std::vector<ContactSample> contacts = reader_->contacts(frame);
  std::vector<float> position, force, friction, overlap;
  std::vector<std::int32_t> pair;
  for (const ContactSample& c : contacts) {
    position.insert(position.end(), c.position.data(), c.position.data() + 3);
    force.insert(force.end(), c.force.data(), c.force.data() + 3);
    friction.insert(friction.end(), c.friction.data(), c.friction.data() + 3);
    overlap.push_back(c.overlap);
    pair.insert(pair.end(), {c.part_a, c.part_b});
  }
  message.add("contacts/position", position.data(), contacts.size(), 3);
  message.add("contacts/force", force.data(), contacts.size(), 3);
  message.add("contacts/friction", friction.data(), contacts.size(), 3);
  message.add("contacts/overlap", overlap.data(), contacts.size());
  message.add("contacts/pair", pair.data(), contacts.size(), 2);
  std::vector<std::int32_t> key;
  std::vector<float> step;
  for (const auto& [tile, h] : reader_->tiles(frame)) {
    key.insert(key.end(), {tile.x, tile.y, tile.z});
    step.push_back(static_cast<float>(h));
  }
  message.add("tiles/key", key.data(), step.size(), 3);
  message.add("tiles/step", step.data(), step.size());
  add_pairs(reader_->pairs(frame), message);
  add_link_ends(reader_->link_ends(frame), message);
  return message.bytes();
}

std::string RecordedRun::with_world(std::int64_t frame, const std::function<std::string(const World&)>& show) {
  struct Counted {
    explicit Counted(std::atomic<int>& n) : count(n), before(count.fetch_add(1)) {}
    ~Counted() { count.fetch_sub(1); }
    std::atomic<int>& count;
    const int before;
  } const counted(asked_);
  if (counted.before >= kMostAsked)
    throw Busy(
        fmt::format("{} slices or fields of stress are being made or wait; ask again when they have come", kMostAsked));
  const std::lock_guard world_lock(world_mutex_);
  const World* world = nullptr;
  {
    const std::lock_guard lock(mutex_);
    refresh();
    if (world_stale_) world_.reset();
    world_stale_ = false;
    if (!world_) world_ = std::make_unique<RebuiltWorld>(*reader_);
    world = &world_->at(*reader_, frame);
  }
  return show(*world);
}

std::string RecordedRun::slice(std::int64_t frame, const SliceRequest& request) {
  return with_world(frame, [&](const World& world) { return message_of(cut_densities(world, request)); });
}

std::string RecordedRun::stress(std::int64_t frame) {
  return with_world(frame, [](const World& world) {
    ArrayMessage message;
    for (int b = 0; b < world.body_count(); ++b) {
      const auto* solid = dynamic_cast<const StressedSolid*>(&world.body(b));
      if (solid == nullptr) continue;
      const StressField field = solid->stress_field();
      std::vector<double> equivalent;
      for (const Mat3& stress : field.stress) equivalent.push_back(von_mises(stress));
      std::vector<float> shown(world.body(b).display().vertices);
      solid->show(equivalent, shown);
      message.add("von_mises", shown.data(), shown.size(), 1, b);
    }
    return message.bytes();
  });
}

std::string RecordedRun::series(std::int64_t from) {
  const std::lock_guard lock(mutex_);
  refresh();
  const auto frames = static_cast<std::size_t>(reader_->frames());
  const std::size_t first = std::min(static_cast<std::size_t>(std::max<std::int64_t>(from, 0)), frames);
  ArrayMessage message;
  const auto add = [&](const std::string& name, const std::vector<double>& values) {
    const std::size_t end = std::min(values.size(), frames);
    message.add(name, values.data() + std::min(first, end), end - std::min(first, end));
  };
  std::vector<double> times(frames);
  for (std::size_t f = first; f < frames; ++f) times[f] = reader_->time(static_cast<std::int64_t>(f));
  add("time", times);
  for (const ReportField& field : report_fields())
    if (std::string_view(field.name) != "time") add(field.name, reader_->series(field.name));
  const SensorRecord record(*reader_);
  for (std::size_t i = 0; i < record.sensors().size(); ++i) {
    const RecordedSensor& s = record.sensors()[i];
    const std::vector<double> rows = record.values(i);
    std::vector<double> column(frames);
    for (std::size_t c = 0; c < s.channels.size(); ++c) {
      for (std::size_t f = first; f < frames; ++f) column[f] = rows[f * s.channels.size() + c];
      add(fmt::format("sensor {} {}", i, c), column);
    }
  }
  return message.bytes();
}

double RecordedRun::frame_rate() {
  const std::lock_guard lock(mutex_);
  if (!reader_) refresh();
  const double seconds = reader_->frame_time();
  return seconds > 0 ? std::min(60.0, 1.0 / seconds) : 30.0;
}

}  // namespace brim::viewer
