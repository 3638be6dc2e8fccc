#include "brim/world/sense/sensors.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "brim/core/error.h"
#include "brim/world/sense/contact_sensor.h"
#include "brim/world/sense/force_sensor.h"
#include "brim/world/sense/level_sensor.h"
#include "brim/world/sense/link_sensor.h"
#include "brim/world/sense/motion_sensor.h"
#include "brim/world/sense/pressure_sensor.h"
#include "brim/world/sense/strain_sensor.h"

namespace brim {

namespace {

/// First number of sensors in memory; differs from those of Sleep, Links and ReferencePoses.
constexpr double kSensorsMark = -0.03125;
/// Marks the contacts of sleeping bodies, in place of the hash of a name.
constexpr double kHeldMark = -1.0;
/// Count of numbers per contact in memory.
constexpr std::size_t kSampleNumbers = 12;

/// FNV-1a of a name; a double holds it exactly.
double name_hash(std::string_view name) {
  std::uint32_t hash = 2166136261u;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
  return hash;
}

template <class T>
std::unique_ptr<Sensor> made(const SensorModel& model, const World& world) {
  return std::make_unique<T>(model, world);
}

void append_sample(const ContactSample& s, std::vector<double>& memory) {
  for (const Vec3f& x : {s.position, s.force, s.friction}) memory.insert(memory.end(), x.begin(), x.end());
  memory.push_back(s.overlap);
  memory.push_back(s.part_a), memory.push_back(s.part_b);
}

ContactSample sample_from(std::span<const double> n) {
  const auto vector = [&](std::size_t i) {
    return Vec3f(static_cast<float>(n[i]), static_cast<float>(n[i + 1]), static_cast<float>(n[i + 2]));
  };
  return {vector(0),
          vector(3),
          vector(6),
          static_cast<float>(n[9]),
          static_cast<std::int32_t>(n[10]),
          static_cast<std::int32_t>(n[11])};
}

}  // namespace

void add_axes(std::vector<SensorChannel>& channels, const std::string& name, const std::string& unit, Taking taking) {
  for (const char* axis : {"_x", "_y", "_z"}) channels.push_back({name + axis, unit, taking});
}

std::unique_ptr<Sensor> make_sensor(const SensorModel& model, const World& world) {
  try {
    if (model.name.empty()) throw InputError("a sensor needs a name");
    if (model.bodies.empty() && model.kind != SensorKind::Link) throw InputError("no body is named");
    if (!(model.least_force >= 0.0) || !std::isfinite(model.least_force))
      throw InputError(fmt::format("least_force {} is not allowed; must be a number from 0", model.least_force));
    if (!(model.gap >= 0.0) || !std::isfinite(model.gap))
      throw InputError(fmt::format("gap {} is not allowed; must be a number from 0", model.gap));
    switch (model.kind) {
      case SensorKind::Force:
        return made<ForceSensor>(model, world);
      case SensorKind::Contact:
        return made<ContactSensor>(model, world);
      case SensorKind::Pressure:
        return made<PressureSensor>(model, world);
      case SensorKind::Motion:
        return made<MotionSensor>(model, world);
      case SensorKind::Strain:
        return made<StrainSensor>(model, world);
      case SensorKind::Distance:
        return made<DistanceSensor>(model, world);
      case SensorKind::Level:
        return made<LevelSensor>(model, world);
      case SensorKind::Link:
        return made<LinkSensor>(model, world);
    }
    throw ProgrammingError("no such kind of sensor");
  } catch (const InputError& e) {
    throw InputError(fmt::format("sensor '{}': {}", model.name, e.what()));
  }
}

int Sensors::add(const SensorModel& model, const World& world) {
  if (find(model.name) >= 0)
    throw InputError(fmt::format("sensor '{}': there is another one of that name", model.name));
  find_bodies(world);
  Entry e;
  e.sensor = make_sensor(model, world);
  e.values.resize(e.sensor->channels().size());
  e.map.resize(e.sensor->map_size());
  e.sensor->read(world, StepReport{}, e.values, e.map);
  e.frame = {e.values, e.map, {}};
  entries_.push_back(std::move(e));
  return static_cast<int>(entries_.size()) - 1;
}

int Sensors::find(const std::string& name) const {
  for (std::size_t i = 0; i < entries_.size(); ++i)
    if (entries_[i].sensor->model().name == name) return static_cast<int>(i);
  return -1;
}

int Sensors::channel(std::size_t i, const std::string& name) const {
  const auto channels = entries_[i].sensor->channels();
  const auto at = std::ranges::find(channels, name, &SensorChannel::name);
  return at == channels.end() ? -1 : static_cast<int>(at - channels.begin());
}

void Sensors::find_bodies(const World& world) {
  bool same = static_cast<int>(bodies_.size()) == world.body_count();
  for (std::size_t b = 0; same && b < bodies_.size(); ++b)
    same = bodies_[b] == Known{&world.body(static_cast<int>(b)), world.body(static_cast<int>(b)).name()};
  if (same) return;
  std::vector<Known> now;
  for (int b = 0; b < world.body_count(); ++b) now.push_back({&world.body(b), world.body(b).name()});
  std::vector<PartRef> parts;
  for (int p = 0; p < world.part_count(); ++p) parts.push_back(world.part(p));
  // Held contacts keep their parts under any numbering.
  const auto number = [&](std::int32_t old) {
    const PartRef& part = parts_[static_cast<std::size_t>(old)];
    for (std::size_t p = 0; p < parts.size(); ++p)
      if (parts[p].index == part.index &&
          now[static_cast<std::size_t>(parts[p].body)] == bodies_[static_cast<std::size_t>(part.body)])
        return static_cast<std::int32_t>(p);
    return std::int32_t{-1};
  };
  for (ContactSample& s : last_) s.part_a = number(s.part_a), s.part_b = number(s.part_b);
  std::erase_if(last_, [](const ContactSample& s) { return s.part_a < 0 || s.part_b < 0; });
  bodies_ = std::move(now);
  parts_ = std::move(parts);
  for (Entry& e : entries_) e.sensor->find_bodies(world);
}

bool Sensors::held(const World& world, const ContactSample& s) const {
  const int a = parts_[static_cast<std::size_t>(s.part_a)].body, b = parts_[static_cast<std::size_t>(s.part_b)].body;
  const bool sleeps_a = world.asleep(a), sleeps_b = world.asleep(b);
  return (sleeps_a && (sleeps_b || world.body(b).immobile())) || (sleeps_b && world.body(a).immobile());
}

void Sensors::begin_step(const World& world) {
  find_bodies(world);
  events_.clear();
  for (Entry& e : entries_) e.sensor->begin_step(world);
}

void Sensors::restored(const World& world) {
  begin_step(world);
  for (Entry& e : entries_) {
    e.sensor->read(world, StepReport{}, e.values, e.map);
    e.frame.values = e.values, e.frame.map = e.map;
  }
}

void Sensors::substep(const World& world, double time, double dt) {
  std::span<const ContactSample> samples = world.contacts();
  if (world.options().sleep) {
    std::erase_if(last_, [&](const ContactSample& s) { return !held(world, s); });
    all_.assign(samples.begin(), samples.end());
    all_.insert(all_.end(), last_.begin(), last_.end());
    for (const ContactSample& s : samples) {
      const int a = parts_[static_cast<std::size_t>(s.part_a)].body,
                b = parts_[static_cast<std::size_t>(s.part_b)].body;
      if (std::ranges::any_of(entries_, [&](const Entry& e) { return e.sensor->concerns(a, b); })) last_.push_back(s);
    }
    samples = all_;
  }
  const std::size_t first = events_.size();
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const std::size_t before = events_.size();
    entries_[i].sensor->substep({world, time, dt, samples}, events_);
    for (std::size_t e = before; e < events_.size(); ++e) events_[e].sensor = static_cast<int>(i);
  }
  std::stable_sort(events_.begin() + static_cast<std::ptrdiff_t>(first), events_.end(),
                   [](const ContactEvent& x, const ContactEvent& y) { return x.time < y.time; });
}

void Sensors::end_step(const World& world, const StepReport& report) {
  for (Entry& e : entries_) {
    e.sensor->read(world, report, e.values, e.map);
    join_frame(e, report);
  }
  ++frame_steps_;
  if (frames_) frame_events_.insert(frame_events_.end(), events_.begin(), events_.end());
  for (const auto& listener : listeners_) listener(world, *this);
}

void Sensors::begin_frame() {
  frames_ = true;
  frame_steps_ = 0;
  frame_events_.clear();
  for (Entry& e : entries_) e.frame.rows.clear();
}

void Sensors::end_frames() {
  begin_frame();
  frames_ = false;
}

void Sensors::join_frame(Entry& e, const StepReport& report) {
  if (frames_ && e.sensor->model().every_step) {
    e.frame.rows.push_back(report.time);
    e.frame.rows.insert(e.frame.rows.end(), e.values.begin(), e.values.end());
  }
  if (frame_steps_ == 0 || !frames_) {
    e.frame.values = e.values, e.frame.map = e.map;
    return;
  }
  const double share = 1.0 / (frame_steps_ + 1);
  for (std::size_t c = 0; c < e.values.size(); ++c) {
    double& sum = e.frame.values[c];
    const double now = e.values[c];
    switch (e.sensor->channels()[c].taking) {
      case Taking::Mean:
        sum += share * (now - sum);
        break;
      case Taking::Sum:
        sum += now;
        break;
      case Taking::Last:
        sum = now;
        break;
      case Taking::Largest:
        sum = std::isnan(sum) || now > sum ? now : sum;
        break;
    }
  }
  for (std::size_t c = 0; c < e.map.size(); ++c) e.frame.map[c] += share * (e.map[c] - e.frame.map[c]);
}

void Sensors::restore_frame(std::size_t i, std::span<const double> values) {
  BRIM_CHECK(values.size(), ==, entries_[i].values.size());
  entries_[i].frame.values.assign(values.begin(), values.end());
}

void Sensors::take(std::vector<double>& memory) {
  for (Entry& e : entries_) e.sensor->take({});
  last_.clear();
  if (memory.size() < 2 || memory[0] != kSensorsMark) return;
  const auto n = static_cast<std::size_t>(std::clamp(memory[1], 0.0, static_cast<double>(memory.size() - 2)));
  const std::span<const double> mine(memory.data() + 2, n);
  for (std::size_t at = 0; at + 2 <= n;) {
    const double what = mine[at];
    const auto m = static_cast<std::size_t>(std::clamp(mine[at + 1], 0.0, static_cast<double>(n - at - 2)));
    const auto numbers = mine.subspan(at + 2, m);
    at += 2 + m;
    for (Entry& e : entries_)
      if (what == name_hash(e.sensor->model().name)) e.sensor->take(numbers);
    if (what != kHeldMark) continue;
    const double most = static_cast<double>(parts_.size());
    for (std::size_t i = 0; i + kSampleNumbers <= m; i += kSampleNumbers)
      if (const double a = numbers[i + 10], b = numbers[i + 11]; a >= 0.0 && a < most && b >= 0.0 && b < most)
        last_.push_back(sample_from(numbers.subspan(i, kSampleNumbers)));
  }
  memory.erase(memory.begin(), memory.begin() + static_cast<std::ptrdiff_t>(2 + n));
}

void Sensors::keep(const World& world, std::vector<double>& memory) const {
  std::vector<double> mine, numbers;
  const auto put = [&](double what) {
    if (numbers.empty()) return;
    mine.push_back(what), mine.push_back(static_cast<double>(numbers.size()));
    mine.insert(mine.end(), numbers.begin(), numbers.end());
    numbers.clear();
  };
  for (const Entry& e : entries_) {
    e.sensor->keep(numbers);
    put(name_hash(e.sensor->model().name));
  }
  // Bodies now asleep will not be searched in the next step.
  for (const ContactSample& s : last_)
    if (held(world, s)) append_sample(s, numbers);
  put(kHeldMark);
  if (mine.empty()) return;
  const double head[] = {kSensorsMark, static_cast<double>(mine.size())};
  mine.insert(mine.begin(), std::begin(head), std::end(head));
  memory.insert(memory.begin(), mine.begin(), mine.end());
}

Sensors* find_sensors(World& world) {
  for (const auto& watcher : world.watchers())
    if (auto* sensors = dynamic_cast<Sensors*>(watcher.get())) return sensors;
  return nullptr;
}

const Sensors* find_sensors(const World& world) {
  for (const auto& watcher : world.watchers())
    if (const auto* sensors = dynamic_cast<const Sensors*>(watcher.get())) return sensors;
  return nullptr;
}

Sensors& sensors_of(World& world) {
  if (Sensors* there = find_sensors(world)) return *there;
  auto made_now = std::make_unique<Sensors>();
  Sensors& sensors = *made_now;
  world.watch(std::move(made_now));
  return sensors;
}

int add_sensor(World& world, const SensorModel& model) { return sensors_of(world).add(model, world); }

}  // namespace brim
