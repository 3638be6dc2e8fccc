#pragma once

#include <memory>
#include <string>
#include <vector>

#include "brim/world/body_sample.h"
#include "brim/world/sense/sensor_metric.h"
#include "brim/world/shown_metric.h"
#include "brim/world/step_report.h"

namespace brim {

/// Data of one frame from which metrics are computed.
struct MeasuredFrame {
  std::int64_t index = 0;  ///< of the frame in the run
  StepReport report;       ///< without its lists
  int steps = 1;
  std::size_t warnings = 0;
  std::vector<BodySample> bodies;          ///< of the watched ones
  std::vector<double> shown;               ///< one per ShownMetric in use
  std::vector<SensorMetric::Pair> sensed;  ///< one per SensorMetric in use
  Vec3 momentum = Vec3::Zero();            ///< [kg m/s] of all movable bodies, if in use
  Vec3 angular = Vec3::Zero();             ///< [kg m²/s] about the origin, likewise
};

/// A metric accumulated over the frames of a window, in constant memory.
/// Tests: tests/world/measures_test.cpp
class MetricFold {
 public:
  virtual ~MetricFold() = default;
  /// @param frame  next frame of the window
  virtual void add(const MeasuredFrame& frame) = 0;
  /// After at least one frame: one number, or one per body for metrics per body.
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
