#pragma once

#include <optional>

#include "brim/world/sense/sensed_points.h"
#include "brim/world/sense/sensor.h"

namespace brim {

/// Position, velocity and acceleration of a material point, or of a whole body: then the mean of its display vertices
/// and the velocity of its centre of mass. Acceleration is the change of velocity over a step divided by its length. On
/// solids also the spin ω: u(x + e) − u(x) = ω × e.
/// Tests: tests/world/sense/motion_sensor_test.cpp
class MotionSensor : public Sensor {
 public:
  MotionSensor(const SensorModel& model, const World& world);
  void find_bodies(const World& world) override;
  void begin_step(const World& world) override;
  void read(const World& world, const StepReport& report, std::span<double> values, std::span<double> map) override;

 private:
  struct State {
    Vec3 x, u, spin;
  };
  State now(const World& world);

  const Body* body_ = nullptr;
  int number_ = -1;  ///< −1: removed
  bool solid_ = false;
  std::optional<SensedPoints> points_;  ///< nothing: the whole body
  Vec3 before_ = Vec3::Zero();          ///< [m/s] at the start of the step
  std::vector<Vec3f> shown_;
};

}  // namespace brim
