#pragma once

#include <string>

#include "brim/world/sense/sensors.h"
#include "support/worlds.h"

namespace brim::testing {

inline SensorModel sensor_on(SensorKind kind, const std::string& body, const std::string& name = "sensor") {
  SensorModel m;
  m.kind = kind, m.name = name, m.bodies = {body};
  return m;
}

/// A reading of the last step.
inline double reading(const World& w, const std::string& sensor, const std::string& channel) {
  const Sensors& s = *find_sensors(w);
  const auto i = static_cast<std::size_t>(s.find(sensor));
  return s.values(i)[static_cast<std::size_t>(s.channel(i, channel))];
}

inline Vec3 reading_of_axes(const World& w, const std::string& sensor, const std::string& channel) {
  return {reading(w, sensor, channel + "_x"), reading(w, sensor, channel + "_y"), reading(w, sensor, channel + "_z")};
}

}  // namespace brim::testing

/// The names that tests of sensors use: `using namespace testing::sensing;`
namespace brim::testing::sensing {

using testing::ball;
using testing::box;
using testing::ground;
using testing::options_at;
using testing::reading;
using testing::reading_of_axes;
using testing::run;
using testing::sensor_on;
using testing::velocity;

}  // namespace brim::testing::sensing
