#pragma once

#include <string>
#include <vector>

namespace brim {

class RunReader;

/// Writes what the sensors of a run have read beside it: sensors.csv, a line a frame; sensor_steps.csv, a line a step,
/// of those that are recorded so; events.csv, a line a contact that began or ended (docs/sensors.md). They follow from
/// run.h5 alone, so that a run that was resumed has the same. Nothing for runs without sensors.
/// @throws InputError  Tests: tests/record/sensor_record_test.cpp
void write_sensor_csv(const RunReader& run, const std::string& folder);

/// The names of these files.
const std::vector<std::string>& sensor_csv_files();

}  // namespace brim
