#include "brim/world/sense/sensor_metric.h"

#include "brim/core/error.h"
#include "brim/world/sense/sensors.h"

namespace brim {

namespace {

NumberFold::Take take_of(const std::string& word) {
  using Take = NumberFold::Take;
  if (word == "last") return Take::Last;
  if (word == "least") return Take::Least;
  if (word == "largest") return Take::Largest;
  return word == "sum" ? Take::SumAfterFirst : Take::Mean;
}

}  // namespace

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
    : take_(take_of(e.take)), reading_(find(world, e.reading)), ratio_(!e.over.sensor.empty()) {
  if (ratio_) over_ = find(world, e.over);
}

SensorMetric::Pair SensorMetric::now(const World& world) const {
  const Sensors& sensors = *find_sensors(world);
  const auto at = [&](const Place& p) { return sensors.frame(p.sensor).values[p.channel]; };
  return {at(reading_), ratio_ ? at(over_) : 1.0};
}

void SensorMetric::Fold::add(const Pair& frame) {
  reading_.add(frame[0]);
  over_.add(frame[1]);
}

}  // namespace brim
