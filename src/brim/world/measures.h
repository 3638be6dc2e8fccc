#pragma once

#include <cmath>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "brim/math/types.h"
#include "brim/world/body_sample.h"
#include "brim/world/expectation.h"
#include "brim/world/metric_fold.h"
#include "brim/world/sense/sensor_metric.h"
#include "brim/world/shown_metric.h"
#include "brim/world/vertex_range.h"
#include "brim/world/world.h"

namespace brim {

/// An expectation and its outcome.
struct ExpectationResult {
  Expectation expectation;
  double value = 0.0;   ///< of the body with the worst value
  std::string body;     ///< that body, when the metric is per body
  bool reached = true;  ///< false: the run ended before the window did
  bool ok = false;      ///< the bound holds

  /// True when a known miss is worse than its known worst value.
  bool worse() const {
    if (ok || !reached || expectation.known_miss.empty()) return false;
    return value > expectation.max ? value > expectation.known_worst : value < expectation.known_worst;
  }
  /// True when the bound holds, or fails within a known miss. A known miss that holds is unexpected too: its mark must
  /// be removed, so that a later failure is noticed.
  bool as_expected() const { return ok == expectation.known_miss.empty() && !worse(); }
};

/// Computes the metrics of expectations frame by frame during a run:
///   of the window: worst_overlap, max_speed, kinetic_energy, energy_rise, momentum_error, angular_error, contacts,
///     substeps (largest), contact_share, cg_iterations, step_seconds, contact_force_{x,y,z} (mean), warnings,
///     failed_steps (count), lowest, highest, drift, impulse_{x,y,z} (sum), energy_growth
///   at its end: final_speed, final_kinetic_energy, stiffness, particles, position_{x,y,z}, tilt_degrees, speed
///   from its start to its end: displacement, displacement_{x,y,z}, speed_kept, acceleration, momentum_change,
///     angular_momentum_change
///   of a body's display: those of ShownMetric
///   of a sensor's readings: sensor
/// The schema of scenes defines each (schema/scene.schema.json). Metrics are accumulated; only the last frame is kept.
/// Tests: tests/world/measures_test.cpp
class Measures {
 public:
  /// @param world         before the first step
  /// @param expectations  to be evaluated; only the bodies they name are watched
  /// @param end           [s] end of windows without one of their own
  Measures(const World& world, std::vector<Expectation> expectations, double end);

  /// Adds the world's state, with the report of the frame that led to it (an empty one for the first frame).
  void add(const World& world, const StepReport& frame, int steps);
  /// The samples of all bodies in the last frame, shape (bodies).
  const std::vector<BodySample>& samples() const { return samples_; }

  /// True when some metric needs the world in the state of every frame.
  bool needs_state() const { return !shown_.empty() || asks_momentum_; }
  /// Adds a frame that was recorded earlier (resume). @param bodies  shape (bodies)
  /// @param world  in the state of that frame where needs_state()
  void restore(const World& world, const StepReport& frame, int steps, std::size_t warnings,
               std::span<const BodySample> bodies);

  std::vector<ExpectationResult> findings() const;

  /// Valid names of metrics.
  static std::vector<std::string> metrics();

 private:
  /// An expectation and its metric over the window so far.
  struct Asked {
    Expectation expectation;
    std::unique_ptr<MetricFold> fold;
    bool begun = false;                ///< the window contains a frame
    int shown = -1, sensed = -1;       ///< index into shown_ or sensed_ for such metrics, else -1
    std::vector<std::size_t> watched;  ///< for metrics per body: indices into watched_
  };
  struct Watched {
    std::string name;
    std::size_t body;
    bool movable;
  };
  /// A body whose display is one rigid piece: its sample follows from its pose.
  struct Posed {
    std::shared_ptr<const VertexRange> vertices;  ///< null for other bodies
    Mat3 start = Mat3::Identity();                ///< rotation at the start
  };
  void sample(const World& world, const StepReport& frame);
  void sample_posed(const Body& body, const Posed& posed, BodySample& s) const;
  void sample_vertices(const Body& body, std::span<const Vec3f> start, BodySample& s);
  void keep(const World& world, const StepReport& frame, int steps, std::size_t warnings,
            std::span<const BodySample> bodies);
  void take(const MeasuredFrame& frame);
  double end_of(const Expectation& e) const { return std::isfinite(e.to) ? e.to : end_; }
  std::unique_ptr<MetricFold> new_fold(const Asked& asked) const;
  ExpectationResult find(const Asked& asked) const;

  std::vector<Asked> asked_;
  double end_;
  double slack_ = 0.0;  ///< [s] tolerance of a window's ends: times are sums of steps
  std::vector<Watched> watched_;
  std::vector<Posed> posed_;  ///< shape (bodies)
  std::vector<std::vector<Vec3f>>
      start_;  ///< display positions at the start, of the other movable bodies, shape (bodies)
  std::vector<Vec3f> scratch_;
  std::vector<BodySample> samples_;
  std::int64_t frames_ = 0;
  MeasuredFrame first_, last_;  ///< the first is added when the second gives the length of a frame
  double particles_ = 0.0;
  std::vector<ShownMetric> shown_;
  std::vector<SensorMetric> sensed_;
  bool asks_momentum_ = false;
};

/// True when an expectation about `wanted` concerns the body `name`: the same, or a numbered copy of it.
bool concerns(const std::string& wanted, const std::string& name);

}  // namespace brim
