#pragma once

#include <array>
#include <span>

#include "brim/world/expectation.h"
#include "brim/world/world.h"

namespace brim {

/// The metric "sensor": a reading of a sensor over the frames of a window, or its ratio to another reading.
/// Tests: tests/world/sense/sensor_metric_test.cpp
class SensorMetric {
 public:
  /// @throws InputError  when a sensor or reading that is named is not there
  SensorMetric(const World& world, const Expectation& expectation);

  /// The two readings of the frame that ended last; the second is 1 where there is no ratio.
  using Pair = std::array<double, 2>;
  Pair now(const World& world) const;
  /// @param values  of the frames of a window, at least one
  double over(std::span<const Pair> values) const;

 private:
  struct Place {
    std::size_t sensor = 0, channel = 0;
  };
  static Place find(const World& world, const Expectation::Reading& reading);
  double taken(std::span<const Pair> values, std::size_t which) const;

  std::string take_;
  Place reading_, over_;
  bool ratio_ = false;
};

}  // namespace brim
