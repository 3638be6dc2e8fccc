#pragma once

#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "brim/world/sense/sensor_model.h"
#include "brim/world/step_report.h"

namespace brim {

class World;

/// Contacts of a sub-step. Those of sleeping bodies are included, as they were when the bodies fell asleep.
struct SensedContacts {
  const World& world;
  double time = 0.0, dt = 0.0;  ///< [s] start and length of the sub-step
  std::span<const ContactSample> samples;
};

/// One sensor of a world: called at sub-steps and steps like a Watcher, it computes one number per channel for a step.
class Sensor {
 public:
  explicit Sensor(SensorModel model) : model_(std::move(model)) {}
  virtual ~Sensor() = default;

  const SensorModel& model() const { return model_; }
  std::span<const SensorChannel> channels() const { return channels_; }
  /// Number of cells of its map, row by row; 0 for sensors without one.
  std::size_t map_size() const {
    return model_.grid ? static_cast<std::size_t>(model_.grid->columns) * static_cast<std::size_t>(model_.grid->rows)
                       : 0;
  }

  /// Bodies were added, removed or renumbered since the last call.
  virtual void find_bodies(const World& world) { (void)world; }
  virtual void begin_step(const World& world) { (void)world; }
  virtual void substep(const SensedContacts& contacts, std::vector<ContactEvent>& events) {
    (void)contacts, (void)events;
  }
  /// The readings of a step, or of the present state if the report has no time.
  /// @param map  [Pa] mean of the step, shape (map_size)
  virtual void read(const World& world, const StepReport& report, std::span<double> values, std::span<double> map) = 0;
  /// True when the contact of two bodies is of interest.
  virtual bool concerns(int body_a, int body_b) const {
    (void)body_a, (void)body_b;
    return false;
  }

  /// State for the next step, as numbers.
  virtual void keep(std::vector<double>& memory) const { (void)memory; }
  virtual void take(std::span<const double> memory) { (void)memory; }

 protected:
  SensorModel model_;
  std::vector<SensorChannel> channels_;
};

/// A channel for each axis: name_x, name_y, name_z.
void add_axes(std::vector<SensorChannel>& channels, const std::string& name, const std::string& unit, Taking taking);

/// Makes a sensor of a world as it is now. @throws InputError  "sensor 'name': what is wrong and what is allowed"
std::unique_ptr<Sensor> make_sensor(const SensorModel& model, const World& world);

}  // namespace brim
