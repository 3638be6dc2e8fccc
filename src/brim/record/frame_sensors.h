#pragma once

#include <optional>
#include <string>
#include <vector>

#include "brim/record/ragged_list.h"
#include "brim/world/sense/sensors.h"

namespace brim {

/// What the sensors of a world read, frame by frame: /sensors and /events of a run (docs/formats.md). Nothing is made
/// for worlds without sensors.
/// Tests: tests/record/sensor_record_test.cpp
class FrameSensors {
 public:
  FrameSensors() = default;
  /// Opens what the file has, and makes what it lacks with readings that are not a number for frames already there.
  /// @param sensors  of the world, or nothing  @param frames  that the file holds
  /// @throws InputError  where a sensor of the file had other readings
  FrameSensors(h5::File& file, const Sensors* sensors, std::uint64_t frames);

  /// Adds the readings of the frame that ended last. @param sensors  nothing: they are not known
  void add(const Sensors* sensors);
  /// Drops all frames from `frames` on.
  void cut(std::uint64_t frames);
  void flush();

 private:
  struct Recorded {
    std::string name;
    std::size_t channels = 0, cells = 0;
    Column values, map;
    std::optional<RaggedList> steps;
  };
  void open(h5::File& file, const std::string& name, const Sensor* sensor, std::uint64_t frames);
  template <class Visit>
  void for_each_list(const Visit& visit);

  std::vector<Recorded> recorded_;
  std::optional<RaggedList> events_;
  std::vector<float> map_;
};

}  // namespace brim
