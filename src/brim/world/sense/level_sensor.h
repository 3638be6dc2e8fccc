#pragma once

#include "brim/grid/tile.h"
#include "brim/world/sense/sensor.h"

namespace brim {

/// A gauge on an upright line: where matter of the sensor's bodies begins and ends along it, by their densities.
/// `level` is the top of the longest run of density above 1/2, `depth` the length of all runs. Not-a-number and 0 where
/// there is none. Reads any kind of body: fluids, grains, a soft body that is pressed down. Tests:
/// tests/world/sense/level_sensor_test.cpp
class LevelSensor : public Sensor {
 public:
  LevelSensor(const SensorModel& model, const World& world);
  void find_bodies(const World& world) override;
  void read(const World& world, const StepReport& report, std::span<double> values, std::span<double> map) override;

 private:
  struct Run {
    double bottom, top;  ///< [m]
  };
  void runs_of(const World& world, int part, std::vector<Run>& runs);

  std::vector<int> parts_;
  std::vector<TileKey> tiles_;
  std::vector<DensityBlock> blocks_;
};

}  // namespace brim
