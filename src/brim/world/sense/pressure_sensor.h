#pragma once

#include <optional>

#include "brim/raster/shape.h"
#include "brim/world/sense/contact_selection.h"
#include "brim/world/sense/sensor.h"

namespace brim {

/// A map of contact pressure on a plane of a body, or of space:
///   p(cell) = −Σ share · F·n / A,   n = x × ŷ / |x|,  A area of a cell,  F force on the sensor's bodies
/// Each contact is spread over a square with its voxel's side, clipped at the border of the grid, so that Σ p A is the
/// total force along −n within the grid. Mean over the sub-steps of a step. The grid follows the pose of the first of
/// the bodies if that is a solid; otherwise it is fixed in space.
/// Tests: tests/world/sense/pressure_sensor_test.cpp
class PressureSensor : public Sensor {
 public:
  PressureSensor(const SensorModel& model, const World& world);
  void find_bodies(const World& world) override;
  bool concerns(int a, int b) const override { return selection_.concerns(a, b); }
  void begin_step(const World& world) override;
  void substep(const SensedContacts& contacts, std::vector<ContactEvent>& events) override;
  void read(const World& world, const StepReport& report, std::span<double> values, std::span<double> map) override;

 private:
  void spread(double s, double t, double width, double amount);

  ContactSelection selection_;
  std::optional<Pose> start_;  ///< of the solid that carries the grid
  const Body* carrier_ = nullptr;
  bool carried_ = false;         ///< the carrier is still in the world
  std::vector<double> impulse_;  ///< [N s] per cell
  double time_ = 0.0, outside_ = 0.0;
};

}  // namespace brim
