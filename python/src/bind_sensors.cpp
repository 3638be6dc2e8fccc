#include <pybind11/stl.h>

#include "arrays.h"
#include "bindings.h"
#include "brim/record/sensor_record.h"
#include "brim/world/sense/sensors.h"
#include "session.h"

namespace brim::python {

namespace {

std::size_t sensor_of(Session& s, int i) {
  const Sensors* sensors = find_sensors(s.world());
  const std::size_t n = sensors == nullptr ? 0 : sensors->size();
  if (i < 0 || static_cast<std::size_t>(i) >= n) throw InputError(fmt::format("sensor {}: there are {}", i, n));
  return static_cast<std::size_t>(i);
}

std::size_t recorded(const SensorRecord& record, int i) {
  if (i < 0 || static_cast<std::size_t>(i) >= record.sensors().size())
    throw InputError(fmt::format("sensor {}: the run has {}", i, record.sensors().size()));
  return static_cast<std::size_t>(i);
}

/// (sensor, began, time [s], body, other, duration [s], impulse [N s] (3,), peak [N]) of each.
py::list events_list(std::span<const ContactEvent> events) {
  py::list list;
  for (const ContactEvent& e : events)
    list.append(py::make_tuple(e.sensor, e.began, e.time, e.body_a, e.body_b, e.duration, array_of(e.impulse), e.peak));
  return list;
}

template <class T>
py::array_t<T> rows_of(const std::vector<T>& x, std::size_t width) {
  const auto n = static_cast<py::ssize_t>(width > 0 ? x.size() / width : 0), w = static_cast<py::ssize_t>(width);
  py::array_t<T> out({n, w});
  std::copy(x.begin(), x.end(), out.mutable_data());
  return out;
}

}  // namespace

void bind_sensors(py::module_& m) {
  auto session = m.attr("Session").cast<py::class_<Session>>();
  session
      .def("sensor_names",
           [](Session& s) {
             std::vector<std::string> names;
             const Sensors* sensors = find_sensors(s.world());
             for (std::size_t i = 0; sensors != nullptr && i < sensors->size(); ++i)
               names.push_back(sensors->sensor(i).model().name);
             return names;
           })
      .def("sensor_kind",
           [](Session& s, int i) {
             return std::string(sensor_kind_word(find_sensors(s.world())->sensor(sensor_of(s, i)).model().kind));
           })
      .def("sensor_channels",
           [](Session& s, int i) {
             std::vector<std::pair<std::string, std::string>> out;
             for (const SensorChannel& c : find_sensors(s.world())->sensor(sensor_of(s, i)).channels())
               out.emplace_back(c.name, c.unit);
             return out;
           })
      .def("sensor_values",
           [](Session& s, int i) {
             const auto v = find_sensors(s.world())->values(sensor_of(s, i));
             return array_of(std::vector<double>(v.begin(), v.end()));
           })
      .def("sensor_map",
           [](Session& s, int i) -> py::object {
             const Sensors& sensors = *find_sensors(s.world());
             const std::size_t at = sensor_of(s, i);
             const auto& grid = sensors.sensor(at).model().grid;
             if (!grid) return py::none();
             const auto map = sensors.map(at);
             return rows_of(std::vector<double>(map.begin(), map.end()), static_cast<std::size_t>(grid->columns));
           })
      .def("sensor_events", [](Session& s) {
        const Sensors* sensors = find_sensors(s.world());
        return sensors == nullptr ? py::list() : events_list(sensors->events());
      });

  py::class_<SensorRecord>(m, "SensorRecord", "Sensors of a recorded run, behind brim.Run.")
      .def(py::init<const RunReader&>())
      .def("sensors",
           [](const SensorRecord& r) {
             py::list list;
             for (const RecordedSensor& s : r.sensors())
               list.append(py::make_tuple(s.name, s.kind, s.channels, s.units, py::make_tuple(s.rows, s.columns),
                                          py::make_tuple(s.width, s.height), s.every_step));
             return list;
           })
      .def("values",
           [](const SensorRecord& r, int i) {
             const std::size_t at = recorded(r, i);
             return rows_of(r.values(at), r.sensors()[at].channels.size());
           })
      .def("steps",
           [](const SensorRecord& r, int i) {
             const std::size_t at = recorded(r, i);
             return rows_of(r.steps(at), r.sensors()[at].channels.size() + 1);
           })
      .def("map",
           [](const SensorRecord& r, int i, std::int64_t frame) {
             const std::size_t at = recorded(r, i);
             return rows_of(r.map(at, frame), static_cast<std::size_t>(r.sensors()[at].columns));
           })
      .def("events", [](const SensorRecord& r) { return events_list(r.all_events()); });
}

}  // namespace brim::python
