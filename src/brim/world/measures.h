#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "brim/math/types.h"
#include "brim/world/expectation.h"
#include "brim/world/sense/sensor_metric.h"
#include "brim/world/shown_metric.h"
#include "brim/world/vertex_range.h"
#include "brim/world/world.h"

namespace brim {

/// Where a body is and how it moves, the same for every kind.
struct BodySample {
  Vec3 center = Vec3::Zero();          ///< [m] mean of the display's vertices
  Vec3 velocity = Vec3::Zero();        ///< [m/s] of the centre of mass; zero for bodies of infinite mass
  Vec3 force = Vec3::Zero();           ///< [N] sum of contact forces on the body in the last sub-step
  double lowest = 0.0, highest = 0.0;  ///< [m] least and largest z of the display's vertices
  double tilt_degrees = 0.0;  ///< between the body's vertical at the start and the vertical now; the rotation is the
                              ///< best fit of all vertices (Kabsch 1976)
};

/// An expectation and what became of it.
struct Finding {
  Expectation expectation;
  double value = 0.0;   ///< of the body that does worst
  std::string body;     ///< that body, when the metric is about bodies
  bool reached = true;  ///< false: the run ended before the window did
  bool ok = false;      ///< the bound holds

  /// True where a bound holds, or misses as is known of it. A known miss that holds is a surprise as well: its mark
  /// must go, so that it cannot be lost again unseen.
  bool as_expected() const { return ok == expectation.known_miss.empty(); }
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
/// The schema of scenes says what each is (schema/scene.schema.json).
/// Tests: tests/world/measures_test.cpp
class Measures {
 public:
  /// @param world         before the first step
  /// @param expectations  what will be asked; only the bodies they name are kept over time
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

  std::vector<Finding> findings() const;

  /// Words that an expectation's metric may be.
  static std::vector<std::string> metrics();

 private:
  struct Frame {
    StepReport report;  ///< without its lists
    int steps = 1;
    std::size_t warnings = 0;
    std::vector<BodySample> bodies;          ///< of the kept ones
    std::vector<double> shown;               ///< shape (shown_)
    std::vector<SensorMetric::Pair> sensed;  ///< shape (sensed_)
    Vec3 momentum = Vec3::Zero();            ///< [kg m/s] of all movable bodies, where asked for
    Vec3 angular = Vec3::Zero();             ///< [kg m²/s] about the origin, likewise
  };
  struct Window {
    std::size_t first = 0, last = 0;
    bool reached = true;
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
  Window window(const Expectation& e) const;
  double world_metric(const std::string& metric, const Window& w) const;
  double shown_metric(std::size_t index, const Window& w) const;
  double sensor_metric(std::size_t index, const Window& w) const;
  double body_metric(const std::string& metric, std::size_t watched, const Window& w) const;
  Finding find(std::size_t expectation) const;

  std::vector<Expectation> expectations_;
  double end_;
  std::vector<Watched> watched_;
  std::vector<Posed> posed_;               ///< shape (bodies)
  std::vector<std::vector<Vec3f>> start_;  ///< display positions at the start, of other movable bodies, shape (bodies)
  std::vector<Vec3f> scratch_;
  std::vector<BodySample> samples_;
  std::vector<Frame> frames_;
  double particles_ = 0.0;
  std::vector<ShownMetric> shown_;
  std::vector<int> shown_of_;  ///< index into shown_ or -1, shape (expectations)
  std::vector<SensorMetric> sensed_;
  std::vector<int> sensed_of_;  ///< likewise into sensed_
  bool asks_momentum_ = false;
};

/// True when an expectation about `wanted` concerns the body `name`: the same, or a numbered copy of it.
bool concerns(const std::string& wanted, const std::string& name);

}  // namespace brim
