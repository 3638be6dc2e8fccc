#include "brim/record/frame_sensors.h"

#include <algorithm>
#include <limits>

#include "brim/core/error.h"
#include "brim/record/sensor_record.h"

namespace brim {

namespace {

using h5::Type;

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
constexpr std::uint64_t kEventRows = 512, kStepRows = 1024;  // in a chunk

constexpr ListColumn kEventColumns[] = {{"sensor", Type::Int32, 0},     {"began", Type::Int32, 0},
                                        {"time", Type::Float64, 0},     {"bodies", Type::Int32, 2},
                                        {"duration", Type::Float64, 0}, {"impulse", Type::Float64, 3},
                                        {"peak", Type::Float64, 0}};

void add_nothing(Column& column, std::size_t width, std::uint64_t frames) {
  const std::vector<double> row(width, kNothing);
  for (std::uint64_t f = 0; f < frames; ++f) column.append(row.data(), 1);
}

void add_nothing_to_map(Column& column, std::size_t cells, std::uint64_t frames) {
  const std::vector<float> row(cells, std::numeric_limits<float>::quiet_NaN());
  for (std::uint64_t f = 0; f < frames; ++f) column.append(row.data(), 1);
}

/// A list that holds nothing of the frames that are there.
RaggedList new_list(h5::File& file, const std::string& group, std::span<const ListColumn> columns, std::uint64_t chunk,
                    std::uint64_t frames) {
  RaggedList list(file, group, columns, chunk, true);
  for (std::uint64_t f = 0; f < frames; ++f) list.close_frame(0);
  list.flush();
  return list;
}

}  // namespace

FrameSensors::FrameSensors(h5::File& file, const Sensors* sensors, std::uint64_t frames) {
  const bool there = file.exists("/sensors");
  if (!there && (sensors == nullptr || sensors->size() == 0)) return;
  std::vector<std::string> names;
  if (there) names = split_lines(file.text("/sensors", "names"));
  const std::size_t recorded = names.size();
  for (std::size_t i = 0; sensors != nullptr && i < sensors->size(); ++i)
    if (const std::string& name = sensors->sensor(i).model().name; std::ranges::find(names, name) == names.end())
      names.push_back(name);
  if (!there) file.group("/sensors");
  for (const std::string& name : names) {
    const int i = sensors == nullptr ? -1 : sensors->find(name);
    open(file, name, i < 0 ? nullptr : &sensors->sensor(static_cast<std::size_t>(i)), frames);
  }
  if (!there || names.size() > recorded) file.attribute("/sensors", "names", join_lines(names));
  events_ = there ? RaggedList(file, "/events", kEventColumns, kEventRows, false)
                  : new_list(file, "/events", kEventColumns, kEventRows, frames);
}

void FrameSensors::open(h5::File& file, const std::string& name, const Sensor* sensor, std::uint64_t frames) {
  const std::string group = "/sensors/" + name;
  const bool there = file.exists(group);
  std::vector<std::string> channels, units;
  if (sensor != nullptr)
    for (const SensorChannel& c : sensor->channels()) channels.push_back(c.name), units.push_back(c.unit);
  if (there && sensor != nullptr && split_lines(file.text(group, "channels")) != channels)
    throw InputError(
        fmt::format("sensor '{}': the run has one of that name with other readings; give it another name", name));
  if (there) channels = split_lines(file.text(group, "channels"));
  Recorded r;
  r.name = name;
  r.channels = channels.size();
  if (!there) {
    file.group(group);
    file.attribute(group, "kind", std::string(sensor_kind_word(sensor->model().kind)));
    file.attribute(group, "channels", join_lines(channels));
    file.attribute(group, "units", join_lines(units));
    r.values = Column(file, group + "/values", Type::Float64, {r.channels}, frame_chunk(8 * r.channels));
    add_nothing(r.values, r.channels, frames);
  } else {
    r.values = Column(file.open(group + "/values"));
  }
  if (there ? file.exists(group + "/map") : sensor->map_size() > 0) {
    if (!there) {
      const SensorModel::Grid& g = *sensor->model().grid;
      file.attribute(group, "width", g.x.norm());
      file.attribute(group, "height", g.y.norm());
      r.cells = sensor->map_size();
      r.map =
          Column(file, group + "/map", Type::Float32,
                 {static_cast<std::uint64_t>(g.rows), static_cast<std::uint64_t>(g.columns)}, frame_chunk(4 * r.cells));
      add_nothing_to_map(r.map, r.cells, frames);
    } else {
      r.map = Column(file.open(group + "/map"));
      const auto shape = r.map.set().shape();
      if (shape.size() != 3) throw InputError(fmt::format("{}/map: has {} axes; it must have 3", group, shape.size()));
      r.cells = static_cast<std::size_t>(shape[1] * shape[2]);
      if (sensor != nullptr && r.cells != sensor->map_size())
        throw InputError(fmt::format("sensor '{}': the run has a map of {} cells of that name; give it another name",
                                     name, r.cells));
    }
  }
  const ListColumn row[] = {{"value", Type::Float64, r.channels + 1}};
  if (there && file.exists(group + "/steps"))
    r.steps = RaggedList(file, group + "/steps", row, kStepRows, false);
  else if (sensor != nullptr && sensor->model().every_step)
    r.steps = new_list(file, group + "/steps", row, kStepRows, frames);
  recorded_.push_back(std::move(r));
}

void FrameSensors::add(const Sensors* sensors) {
  for (Recorded& r : recorded_) {
    const int i = sensors == nullptr ? -1 : sensors->find(r.name);
    if (i < 0) {
      add_nothing(r.values, r.channels, 1);
      if (r.cells > 0) add_nothing_to_map(r.map, r.cells, 1);
      if (r.steps) r.steps->close_frame(0);
      continue;
    }
    const SensorFrame& frame = sensors->frame(static_cast<std::size_t>(i));
    r.values.append(frame.values.data(), 1);
    if (r.cells > 0) {
      map_.assign(frame.map.begin(), frame.map.end());
      r.map.append(map_.data(), 1);
    }
    if (r.steps) {
      const std::size_t rows = frame.rows.size() / (r.channels + 1);
      r.steps->append_rows(0, frame.rows.data(), rows);
      r.steps->close_frame(rows);
    }
  }
  if (!events_) return;
  const std::span<const ContactEvent> list =
      sensors == nullptr ? std::span<const ContactEvent>{} : sensors->frame_events();
  // Numbers of the record, in which sensors that are gone keep theirs.
  const auto number = [&](const ContactEvent& e) {
    const std::string& name = sensors->sensor(static_cast<std::size_t>(e.sensor)).model().name;
    return static_cast<std::int32_t>(std::ranges::find(recorded_, name, &Recorded::name) - recorded_.begin());
  };
  events_->append<std::int32_t>(0, list, 1, [&](const ContactEvent& e, std::int32_t* x) { *x = number(e); });
  events_->append<std::int32_t>(1, list, 1, [](const ContactEvent& e, std::int32_t* x) { *x = e.began ? 1 : 0; });
  events_->append<double>(2, list, 1, [](const ContactEvent& e, double* x) { *x = e.time; });
  events_->append<std::int32_t>(3, list, 2,
                                [](const ContactEvent& e, std::int32_t* x) { x[0] = e.body_a, x[1] = e.body_b; });
  events_->append<double>(4, list, 1, [](const ContactEvent& e, double* x) { *x = e.duration; });
  events_->append<double>(5, list, 3,
                          [](const ContactEvent& e, double* x) { std::copy(e.impulse.begin(), e.impulse.end(), x); });
  events_->append<double>(6, list, 1, [](const ContactEvent& e, double* x) { *x = e.peak; });
  events_->close_frame(list.size());
}

template <class Visit>
void FrameSensors::for_each_list(const Visit& visit) {
  for (Recorded& r : recorded_) {
    visit(r.values);
    if (r.cells > 0) visit(r.map);
    if (r.steps) visit(*r.steps);
  }
  if (events_) visit(*events_);
}

void FrameSensors::cut(std::uint64_t frames) {
  for_each_list([&](auto& list) { list.cut(frames); });
}

void FrameSensors::flush() {
  for_each_list([](auto& list) { list.flush(); });
}

}  // namespace brim
