#pragma once

#include <optional>
#include <string>
#include <vector>

#include "brim/record/ragged_list.h"
#include "brim/world/sense/sensors.h"

namespace brim {

/// Readings of a world's sensors, frame by frame: /sensors and /events of a run (docs/formats.md). Nothing is written
/// for worlds without sensors.
/// Tests: tests/record/sensor_record_test.cpp
class FrameSensors {
 public:
  FrameSensors() = default;
  /// Opens existing data sets, and creates missing ones with NaN for frames already recorded.
  /// @param sensors  of the world, or null  @param frames  number in the file
  /// @throws InputError  when a sensor in the file has other channels
  FrameSensors(h5::File& file, const Sensors* sensors, std::uint64_t frames);

  /// Adds the readings of the last frame. @param sensors  null: unknown
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
