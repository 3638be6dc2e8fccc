#pragma once

#include "brim/grid/tile.h"
#include "brim/world/sense/sensor.h"

namespace brim {

/// A gauge on a vertical line: intervals of material of the sensor's bodies along it, from their densities. `level` is
/// the top of the longest interval of density above 1/2 (NaN when there is none), `depth` the length of all intervals.
/// Works for any kind of body: fluids, grains, a compressed soft body. Tests:
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
