#pragma once

#include <array>

#include "brim/world/expectation.h"
#include "brim/world/number_fold.h"
#include "brim/world/world.h"

namespace brim {

/// The metric "sensor": a reading of a sensor over the frames of a window, or its ratio to another reading.
/// Tests: tests/world/sense/sensor_metric_test.cpp
class SensorMetric {
 public:
  /// @throws InputError  when a named sensor or reading does not exist
  SensorMetric(const World& world, const Expectation& expectation);

  /// The two readings of the last frame; the second is 1 when there is no ratio.
  using Pair = std::array<double, 2>;
  Pair now(const World& world) const;

  /// The metric accumulated over the frames of a window.
  class Fold {
   public:
    Fold(NumberFold::Take take, bool ratio) : reading_(take), over_(take), ratio_(ratio) {}
    void add(const Pair& frame);
    double value() const { return ratio_ ? reading_.value() / over_.value() : reading_.value(); }

   private:
    NumberFold reading_, over_;
    bool ratio_;
  };
  /// An empty accumulation.
  Fold fold() const { return {take_, ratio_}; }

 private:
  struct Place {
    std::size_t sensor = 0, channel = 0;
  };
  static Place find(const World& world, const Expectation::Reading& reading);

  NumberFold::Take take_;
  Place reading_, over_;
  bool ratio_ = false;
};

}  // namespace brim
