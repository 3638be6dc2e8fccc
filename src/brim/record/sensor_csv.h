#pragma once

#include <string>
#include <vector>

namespace brim {

class RunReader;

/// Writes the sensor readings of a run into its folder: sensors.csv, a line per frame; sensor_steps.csv, a line per
/// step, for sensors recorded every step; events.csv, a line per begin or end of a contact (docs/sensors.md). They
/// depend only on run.h5, so a resumed run gives the same. Nothing for runs without sensors.
/// @throws InputError  Tests: tests/record/sensor_record_test.cpp
void write_sensor_csv(const RunReader& run, const std::string& folder);

/// Names of these files.
const std::vector<std::string>& sensor_csv_files();

}  // namespace brim
