#include "brim/scene/sensors.h"

#include <algorithm>
#include <map>
#include <vector>

#include "brim/core/printable.h"
#include "brim/scene/constraints.h"
#include "brim/scene/validate.h"
#include "brim/world/sense/sensors.h"

namespace brim {

namespace {

const std::map<std::string, SensorKind>& sensor_kinds() {
  static const std::map<std::string, SensorKind> kinds = {
      {"force", SensorKind::Force},   {"contact", SensorKind::Contact}, {"pressure", SensorKind::Pressure},
      {"motion", SensorKind::Motion}, {"strain", SensorKind::Strain},   {"distance", SensorKind::Distance},
      {"level", SensorKind::Level},   {"link", SensorKind::Link}};
  return kinds;
}

/// The names that a word or a list of words stands for.
std::vector<std::string> sensed_names(const Node& n, const Json* groups) {
  std::vector<std::string> words, names;
  if (n.json().is_string())
    words.push_back(n.string());
  else
    for (std::size_t i = 0; i < n.size(); ++i) words.push_back(n.at(i).string());
  for (const std::string& word : words) {
    if (groups == nullptr || !groups->contains(word)) {
      names.push_back(word);
      continue;
    }
    for (const Json& name : groups->at(word)) names.push_back(name.get<std::string>());
  }
  return names;
}

std::string listed_names(const std::vector<std::string>& words) {
  std::string list;
  for (const std::string& w : words) list += (list.empty() ? "" : ", ") + w;
  return list;
}

std::string did_you_mean(const std::string& word, const std::vector<std::string>& known) {
  const std::string near = nearest_word(word, known);
  return near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near);
}

/// Calls f(sensor node, channel node) for the readings that expectations ask for.
template <class F>
void for_asked(const Node& root, const F& f) {
  for (std::size_t i = 0; i < root.at("expect").size(); ++i) {
    const Node n = root.at("expect").at(i);
    if (n.string("metric") != "sensor") continue;
    f(n.at("sensor"), n.at("channel"));
    if (n.has("over")) f(n.at("over").at("sensor"), n.at("over").at("channel"));
  }
}

}  // namespace

SensorModel read_sensor(const Node& n, const Json* groups) {
  SensorModel m;
  m.name = n.string("name");
  if (printable(m.name) != m.name || m.name.find('/') != std::string::npos || m.name.front() == '.')
    throw n.at("name").error(fmt::format(
        "\"{}\" is not allowed; must have no / and no control characters and not begin with a dot", printable(m.name)));
  m.kind = sensor_kinds().at(n.string("kind"));
  m.every_step = n.string("sample") == "step";
  if (n.has("body")) m.bodies = sensed_names(n.at("body"), groups);
  if (n.has("with")) m.with = sensed_names(n.at("with"), groups);
  if (n.has("region")) m.region = read_region(n.at("region"));
  if (n.has("follows")) m.follows = n.boolean("follows");
  if (n.has("point")) m.point = n.vec3("point");
  if (n.has("part")) m.part = static_cast<int>(n.integer("part"));
  if (n.has("to")) m.to = n.string("to");
  if (n.has("to_point")) m.to_point = n.vec3("to_point");
  if (n.has("about")) m.about = n.vec3("about");
  if (n.has("least_force")) m.least_force = n.number("least_force");
  if (n.has("gap")) m.gap = n.number("gap");
  if (n.has("link")) m.link = n.string("link");
  if (n.has("grid")) {
    const Node g = n.at("grid");
    const std::vector<int> cells = g.at("cells").integers();
    m.grid = SensorModel::Grid{g.vec3("origin"), g.vec3("x"), g.vec3("y"),
                               cells[0],         cells[1],    g.number_if("smoothing").value_or(-1.0)};
    for (const char* side : {"x", "y"})
      if (!(g.vec3(side).norm() > 0.0)) throw g.at(side).error("[0,0,0] is not allowed; must be a side of some length");
    if (std::abs(m.grid->x.normalized().dot(m.grid->y.normalized())) > 1e-6)
      throw g.at("y").error(fmt::format("{} is not allowed; must be at a right angle to \"x\", {}",
                                        shown(g.at("y").json()), shown(g.at("x").json())));
  }
  return m;
}

void check_sensor(const Node& n, const Json* groups, std::set<std::string>& names) {
  if (const SensorModel m = read_sensor(n, groups); !names.insert(m.name).second)
    throw n.at("name").error(fmt::format("\"{}\" is given twice; names must be unique", m.name));
}

void add_sensors(const Node& root, World& world) {
  const Node list = root.at("sensors");
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Node n = list.at(i);
    n.placed([&] { add_sensor(world, read_sensor(n, &root.at("groups").json())); });
  }
  for_asked(root, [&](const Node& sensor, const Node& channel) {
    const Sensors* sensors = find_sensors(world);
    std::vector<std::string> known;
    for (std::size_t i = 0; sensors != nullptr && i < sensors->size(); ++i)
      known.push_back(sensors->sensor(i).model().name);
    const auto at = std::ranges::find(known, sensor.string());
    if (at == known.end())
      throw sensor.error(fmt::format("\"{}\" is not a sensor of this scene; must be one of: {}{}", sensor.string(),
                                     listed_names(known), did_you_mean(sensor.string(), known)));
    const auto i = static_cast<std::size_t>(at - known.begin());
    if (sensors->channel(i, channel.string()) >= 0) return;
    known.clear();
    for (const SensorChannel& c : sensors->sensor(i).channels()) known.push_back(c.name);
    throw channel.error(fmt::format("\"{}\" is not a reading of the sensor \"{}\"; must be one of: {}{}",
                                    channel.string(), sensor.string(), listed_names(known),
                                    did_you_mean(channel.string(), known)));
  });
}

}  // namespace brim
