#include "brim/world/sense/sensor_metric.h"

#include <algorithm>
#include <cmath>

#include "brim/core/error.h"
#include "brim/world/sense/sensors.h"

namespace brim {

SensorMetric::Place SensorMetric::find(const World& world, const Expectation::Reading& r) {
  const Sensors* sensors = find_sensors(world);
  const int i = sensors == nullptr ? -1 : sensors->find(r.sensor);
  if (i < 0) throw InputError(fmt::format("there is no sensor \"{}\"; this metric must name one", r.sensor));
  const auto sensor = static_cast<std::size_t>(i);
  const int c = sensors->channel(sensor, r.channel);
  if (c < 0) throw InputError(fmt::format("the sensor \"{}\" has no reading \"{}\"", r.sensor, r.channel));
  return {sensor, static_cast<std::size_t>(c)};
}

SensorMetric::SensorMetric(const World& world, const Expectation& e)
    : take_(e.take), reading_(find(world, e.reading)), ratio_(!e.over.sensor.empty()) {
  if (ratio_) over_ = find(world, e.over);
}

SensorMetric::Pair SensorMetric::now(const World& world) const {
  const Sensors& sensors = *find_sensors(world);
  const auto at = [&](const Place& p) { return sensors.frame(p.sensor).values[p.channel]; };
  return {at(reading_), ratio_ ? at(over_) : 1.0};
}

double SensorMetric::taken(std::span<const Pair> values, std::size_t which) const {
  if (take_ == "last") return values.back()[which];
  double sum = 0.0, least = values[0][which], largest = least;
  const std::size_t first = take_ == "sum" ? 1 : 0;  // a frame's reading speaks of the time before it
  for (std::size_t i = first; i < values.size(); ++i) {
    const double x = values[i][which];
    if (std::isnan(x)) return x;  // must not hide behind a comparison
    sum += x, least = std::min(least, x), largest = std::max(largest, x);
  }
  if (take_ == "least") return least;
  if (take_ == "largest") return largest;
  return take_ == "sum" ? sum : sum / static_cast<double>(values.size());
}

double SensorMetric::over(std::span<const Pair> values) const {
  return ratio_ ? taken(values, 0) / taken(values, 1) : taken(values, 0);
}

}  // namespace brim
