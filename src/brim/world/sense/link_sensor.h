#pragma once

#include "brim/world/sense/sensor.h"

namespace brim {

/// Force and coordinate of an attachment or joint in the last sub-step (LinkReport).
/// Tests: tests/world/sense/sensors_test.cpp
class LinkSensor : public Sensor {
 public:
  LinkSensor(const SensorModel& model, const World& world);
  void read(const World& world, const StepReport& report, std::span<double> values, std::span<double> map) override;

 private:
  std::int64_t link_ = 0;  ///< World::attachment_id
};

}  // namespace brim
