#pragma once

#include <string>

#include "brim/world/sense/sensors.h"

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
