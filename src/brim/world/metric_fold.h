#pragma once

#include <memory>
#include <string>
#include <vector>

#include "brim/world/body_sample.h"
#include "brim/world/sense/sensor_metric.h"
#include "brim/world/shown_metric.h"
#include "brim/world/step_report.h"

namespace brim {

/// What metrics are found from in one frame.
struct MeasuredFrame {
  std::int64_t index = 0;  ///< of the frame in the run
  StepReport report;       ///< without its lists
  int steps = 1;
  std::size_t warnings = 0;
  std::vector<BodySample> bodies;          ///< of the watched ones
  std::vector<double> shown;               ///< one per ShownMetric that is asked for
  std::vector<SensorMetric::Pair> sensed;  ///< one per SensorMetric that is asked for
  Vec3 momentum = Vec3::Zero();            ///< [kg m/s] of all movable bodies, where asked for
  Vec3 angular = Vec3::Zero();             ///< [kg m²/s] about the origin, likewise
};

/// A metric over the frames of a window, taken in one after another: what it keeps does not grow with the window.
/// Tests: tests/world/measures_test.cpp
class MetricFold {
 public:
  virtual ~MetricFold() = default;
  /// @param frame  of the window, after those that were added before
  virtual void add(const MeasuredFrame& frame) = 0;
  /// After at least one frame: one number, or one per body where the metric is about bodies.
  virtual std::vector<double> values() const = 0;

  static bool about_bodies(const std::string& metric);
  /// Metrics of the world and of bodies; not those of ShownMetric.
  static std::vector<std::string> metrics();

  /// @param particles  value of the metric "particles"
  static std::unique_ptr<MetricFold> of_world(const std::string& metric, double particles);
  /// @param bodies  indices into MeasuredFrame::bodies
  static std::unique_ptr<MetricFold> of_bodies(const std::string& metric, std::vector<std::size_t> bodies);
  /// @param index  into MeasuredFrame::shown
  static std::unique_ptr<MetricFold> of_shown(const ShownMetric& metric, std::size_t index);
  /// @param index  into MeasuredFrame::sensed
  static std::unique_ptr<MetricFold> of_sensor(const SensorMetric& metric, std::size_t index);
};

}  // namespace brim
