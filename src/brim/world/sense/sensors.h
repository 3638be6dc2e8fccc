#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "brim/world/sense/sensor.h"
#include "brim/world/watcher.h"
#include "brim/world/world.h"

namespace brim {

/// Readings of a sensor over a frame: its steps combined per channel (Taking).
struct SensorFrame {
  std::vector<double> values;  ///< one per channel
  std::vector<double> map;     ///< [Pa] mean over the frame, shape (map_size)
  /// For sensors recorded every step: time [s] and values, step by step, shape (steps, 1 + channels).
  std::vector<double> rows;
};

/// The sensors of a world. They read it after every step and change nothing; contact forces are summed over all
/// sub-steps, so impulses are complete. Present contacts, and the contacts of sleeping bodies, are part of the world's
/// state, in its memory:
///   memory: [−1/32, n, n numbers: (hash of a sensor's name, m, m numbers ...) ..., others ...]
/// Same bits for any number of threads.  Tests: tests/world/sense/sensors_test.cpp
class Sensors : public Watcher {
 public:
  /// Adds a sensor, for the world as it is now. @return its number
  /// @throws InputError  "sensor 'name': what is wrong and what is allowed"
  int add(const SensorModel& model, const World& world);
  std::size_t size() const { return entries_.size(); }
  const Sensor& sensor(std::size_t i) const { return *entries_[i].sensor; }
  /// The number of a sensor, or −1.
  int find(const std::string& name) const;
  /// The number of a channel of a sensor, or −1.
  int channel(std::size_t i, const std::string& name) const;

  /// Readings of the last step, one per channel; before the first step those of the state.
  std::span<const double> values(std::size_t i) const { return entries_[i].values; }
  /// [Pa] of the last step, row by row, shape (map_size).
  std::span<const double> map(std::size_t i) const { return entries_[i].map; }
  /// Contacts that began or ended in the last step.
  std::span<const ContactEvent> events() const { return events_; }
  /// Registers a function called after every step, on the stepping thread. World::step passes on its exceptions.
  void listen(std::function<void(const World&, const Sensors&)> listener) { listeners_.push_back(std::move(listener)); }

  /// Begins a frame, to which all steps until the next call belong. Without frames each step is a frame, and its events
  /// and rows are not kept.
  void begin_frame();
  void end_frames();
  const SensorFrame& frame(std::size_t i) const { return entries_[i].frame; }
  std::span<const ContactEvent> frame_events() const { return frame_events_; }
  /// Restores the readings of a recorded frame. @param values  one per channel
  void restore_frame(std::size_t i, std::span<const double> values);

  void begin_step(const World& world) override;
  void restored(const World& world) override;
  void substep(const World& world, double time, double dt) override;
  void end_step(const World& world, const StepReport& report) override;
  void take(std::vector<double>& memory) override;
  void keep(const World& world, std::vector<double>& memory) const override;

 private:
  struct Entry {
    std::unique_ptr<Sensor> sensor;
    std::vector<double> values, map;
    SensorFrame frame;
  };
  /// A body as last seen by the sensors.
  struct Known {
    const Body* body;
    std::string name;
    bool operator==(const Known&) const = default;
  };
  void find_bodies(const World& world);
  /// True when neither side of a contact moves, so that the step leaves it out.
  bool held(const World& world, const ContactSample& s) const;
  void join_frame(Entry& entry, const StepReport& report);

  std::vector<Entry> entries_;
  std::vector<Known> bodies_;
  std::vector<PartRef> parts_;
  std::vector<ContactSample> last_;  ///< contacts of interest of the last sub-step, if bodies may sleep
  std::vector<ContactSample> all_;
  std::vector<ContactEvent> events_, frame_events_;
  std::vector<std::function<void(const World&, const Sensors&)>> listeners_;
  int frame_steps_ = 0;
  bool frames_ = false;
};

/// The sensors of a world, created if there are none.
Sensors& sensors_of(World& world);
/// The same, or null.
Sensors* find_sensors(World& world);
const Sensors* find_sensors(const World& world);
/// Adds a sensor to a world. @return its number  @throws InputError  as Sensors::add
int add_sensor(World& world, const SensorModel& model);

}  // namespace brim
