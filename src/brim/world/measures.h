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

/// An expectation and what became of it.
struct ExpectationResult {
  Expectation expectation;
  double value = 0.0;   ///< of the body that does worst
  std::string body;     ///< that body, when the metric is about bodies
  bool reached = true;  ///< false: the run ended before the window did
  bool ok = false;      ///< the bound holds

  /// True where a known miss is worse than is known of it.
  bool worse() const {
    if (ok || !reached || expectation.known_miss.empty()) return false;
    return value > expectation.max ? value > expectation.known_worst : value < expectation.known_worst;
  }
  /// True where a bound holds, or misses as is known of it. A known miss that holds is a surprise as well: its mark
  /// must go, so that it cannot be lost again unseen.
  bool as_expected() const { return ok == expectation.known_miss.empty() && !worse(); }
};

/// Watches a run frame by frame and finds the metrics that expectations are about:
///   of the window: worst_overlap, max_speed, kinetic_energy, energy_rise, momentum_error, angular_error, contacts,
///     substeps (largest), contact_share, cg_iterations, step_seconds, contact_force_{x,y,z} (mean), warnings,
///     failed_steps (count), lowest, highest, drift, impulse_{x,y,z} (sum), energy_growth
///   at its end: final_speed, final_kinetic_energy, stiffness, particles, position_{x,y,z}, tilt_degrees, speed
///   from its start to its end: displacement, displacement_{x,y,z}, speed_kept, acceleration, momentum_change,
///     angular_momentum_change
///   of what a body shows: those of ShownMetric
///   of what a sensor reads: sensor
/// The schema of scenes says what each is (schema/scene.schema.json). Of the frames nothing is kept but the last: every
/// metric is found as they come.
/// Tests: tests/world/measures_test.cpp
class Measures {
 public:
  /// @param world         before the first step
  /// @param expectations  what will be asked; only the bodies they name are watched
  /// @param end           [s] end of the windows that have none
  Measures(const World& world, std::vector<Expectation> expectations, double end);

  /// Takes the world's state in, with the report of the frame that led to it (an empty one for the first frame).
  void add(const World& world, const StepReport& frame, int steps);
  /// The samples of all bodies in the last frame, shape (bodies).
  const std::vector<BodySample>& samples() const { return samples_; }

  /// True when what is asked needs the world in the state of every frame.
  bool needs_state() const { return !shown_.empty() || asks_momentum_; }
  /// Takes in a frame that was recorded earlier (resume). @param bodies  shape (bodies)
  /// @param world  in the state of that frame where needs_state()
  void restore(const World& world, const StepReport& frame, int steps, std::size_t warnings,
               std::span<const BodySample> bodies);

  std::vector<ExpectationResult> findings() const;

  /// Words that an expectation's metric may be.
  static std::vector<std::string> metrics();

 private:
  /// An expectation and its metric over the window so far.
  struct Asked {
    Expectation expectation;
    std::unique_ptr<MetricFold> fold;
    bool begun = false;                ///< the window has a frame
    int shown = -1, sensed = -1;       ///< index into shown_ or sensed_ of metrics that are there, -1 of others
    std::vector<std::size_t> watched;  ///< of metrics about bodies: those concerned, indices into watched_
  };
  struct Watched {
    std::string name;
    std::size_t body;
    bool movable;
  };
  /// A body whose display is one rigid piece: what is needed of it follows from its pose.
  struct Posed {
    std::shared_ptr<const VertexRange> vertices;  ///< nothing for other bodies
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
  double slack_ = 0.0;  ///< [s] by which a frame may miss the ends of a window: times are sums of steps
  std::vector<Watched> watched_;
  std::vector<Posed> posed_;               ///< shape (bodies)
  std::vector<std::vector<Vec3f>> start_;  ///< display positions at the start, of other movable bodies, shape (bodies)
  std::vector<Vec3f> scratch_;
  std::vector<BodySample> samples_;
  std::int64_t frames_ = 0;
  MeasuredFrame first_, last_;  ///< the first is taken when the second tells how long a frame is
  double particles_ = 0.0;
  std::vector<ShownMetric> shown_;
  std::vector<SensorMetric> sensed_;
  bool asks_momentum_ = false;
};

/// True when an expectation about `wanted` concerns the body `name`: the same, or a numbered copy of it.
bool concerns(const std::string& wanted, const std::string& name);

}  // namespace brim
