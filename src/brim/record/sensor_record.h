#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "brim/record/run_reader.h"
#include "brim/world/sense/sensor_model.h"

namespace brim {

/// A sensor as described by a run file.
struct RecordedSensor {
  std::string name, kind;
  std::vector<std::string> channels, units;
  int columns = 0, rows = 0;         ///< cells of its map; 0 without one
  double width = 0.0, height = 0.0;  ///< [m] of its map
  bool every_step = false;           ///< readings of every step are recorded too
};

/// Reads the sensor readings of a run (docs/formats.md). Every function throws InputError for unknown frames and
/// numbers, and for damaged files.  Tests: tests/record/sensor_record_test.cpp
class SensorRecord {
 public:
  explicit SensorRecord(const RunReader& run);
  ~SensorRecord();

  const std::vector<RecordedSensor>& sensors() const;
  /// Readings of all frames, shape (frames, channels).
  std::vector<double> values(std::size_t sensor) const;
  /// [Pa] map of a frame, shape (rows, columns).
  std::vector<float> map(std::size_t sensor, std::int64_t frame) const;
  /// Time [s] and readings of every step, shape (steps, 1 + channels).
  std::vector<double> steps(std::size_t sensor) const;
  /// Contacts that began or ended in a frame; `sensor` is a number of sensors().
  std::vector<ContactEvent> events(std::int64_t frame) const;
  /// Those of all frames.
  std::vector<ContactEvent> all_events() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The keyword of a kind in scenes and records.
const char* sensor_kind_word(SensorKind kind);
/// Lists as one text attribute, one line per item.
std::string join_lines(const std::vector<std::string>& lines);
std::vector<std::string> split_lines(const std::string& text);

}  // namespace brim
