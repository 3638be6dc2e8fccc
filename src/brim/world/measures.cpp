#include "brim/world/measures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "brim/body/changing_surface.h"
#include "brim/body/posed_display.h"
#include "brim/body/spinning_balls.h"
#include "brim/math/svd3.h"

namespace brim {

namespace {

/// Best-fit rotation from the points a to b, both relative to their centres (Kabsch 1976).
Mat3 best_rotation(std::span<const Vec3f> a, std::span<const Vec3f> b) {
  Vec3 ca = Vec3::Zero(), cb = Vec3::Zero();
  for (std::size_t i = 0; i < a.size(); ++i) {
    ca += a[i].cast<double>();
    cb += b[i].cast<double>();
  }
  ca /= static_cast<double>(a.size());
  cb /= static_cast<double>(a.size());
  Mat3 H = Mat3::Zero();
  for (std::size_t i = 0; i < a.size(); ++i) H += (b[i].cast<double>() - cb) * (a[i].cast<double>() - ca).transpose();
  return polar_rotation(H);
}

/// True when an expectation is about a body.
bool asks_about(const Expectation& e, const std::string& body, bool movable) {
  return MetricFold::about_bodies(e.metric) && (e.body.empty() ? movable : concerns(e.body, body));
}

/// @param up  cosine, R_zz of a rotation
double angle_to_vertical(double up) { return std::acos(std::clamp(up, -1.0, 1.0)) * 180.0 / std::numbers::pi; }

}  // namespace

bool concerns(const std::string& wanted, const std::string& name) {
  if (!name.starts_with(wanted)) return false;
  if (name.size() == wanted.size()) return true;
  return name[wanted.size()] == '.' && name.size() > wanted.size() + 1 &&
         std::all_of(name.begin() + static_cast<std::ptrdiff_t>(wanted.size()) + 1, name.end(),
                     [](char c) { return c >= '0' && c <= '9'; });
}

std::vector<std::string> Measures::metrics() {
  std::vector<std::string> all = MetricFold::metrics();
  all.insert(all.end(), ShownMetric::names().begin(), ShownMetric::names().end());
  return all;
}

Measures::Measures(const World& world, std::vector<Expectation> expectations, double end) : end_(end) {
  const auto count = static_cast<std::size_t>(world.body_count());
  posed_.resize(count);
  VertexRanges ranges;
  start_.resize(count);
  samples_.resize(count);
  for (std::size_t b = 0; b < count; ++b) {
    const Body& body = world.body(static_cast<int>(b));
    const bool movable = std::isfinite(body.mass());
    if (const PosedDisplay* pieces = posed_display(body); pieces != nullptr && pieces->piece_count() == 1)
      posed_[b] = {ranges.of(pieces->piece(0).surface().vertices), pieces->piece(0).pose().rotation};
    if (movable) {
      if (body.v_size() > 6) particles_ += static_cast<double>(body.v_size() / velocities_per_node(body));
      // A changing surface has no persistent vertices from which a rotation could be found.
      if (posed_[b].vertices == nullptr && !changing_surface(body)) display_now(body, start_[b]);
    }
    if (std::ranges::any_of(expectations, [&](const Expectation& e) { return asks_about(e, body.name(), movable); }))
      watched_.push_back({body.name(), b, movable});
  }
  for (Expectation& e : expectations) {
    asks_momentum_ = asks_momentum_ || e.metric == "momentum_change" || e.metric == "angular_momentum_change";
    Asked asked;
    if (ShownMetric::knows(e.metric)) {
      asked.shown = static_cast<int>(shown_.size());
      shown_.emplace_back(world, e);
    } else if (e.metric == "sensor") {
      asked.sensed = static_cast<int>(sensed_.size());
      sensed_.emplace_back(world, e);
    }
    for (std::size_t i = 0; i < watched_.size(); ++i)
      if (asks_about(e, watched_[i].name, watched_[i].movable)) asked.watched.push_back(i);
    asked.expectation = std::move(e);
    asked.fold = new_fold(asked);
    asked_.push_back(std::move(asked));
  }
}

std::unique_ptr<MetricFold> Measures::new_fold(const Asked& a) const {
  if (a.shown >= 0) {
    const auto i = static_cast<std::size_t>(a.shown);
    return MetricFold::of_shown(shown_[i], i);
  }
  if (a.sensed >= 0) {
    const auto i = static_cast<std::size_t>(a.sensed);
    return MetricFold::of_sensor(sensed_[i], i);
  }
  const std::string& metric = a.expectation.metric;
  return MetricFold::about_bodies(metric) ? MetricFold::of_bodies(metric, a.watched)
                                          : MetricFold::of_world(metric, particles_);
}

void Measures::sample_posed(const Body& body, const Posed& posed, BodySample& s) const {
  const Pose& pose = posed_display(body)->piece(0).pose();
  if (posed.vertices->empty()) return;
  s.center = pose.rotation * posed.vertices->mean() + pose.translation;
  const auto [least, largest] = posed.vertices->along(pose.rotation.row(2).transpose());
  s.lowest = least + pose.translation.z();
  s.highest = largest + pose.translation.z();
  if (std::isfinite(body.mass())) s.tilt_degrees = angle_to_vertical((pose.rotation * posed.start.transpose())(2, 2));
}

void Measures::sample_vertices(const Body& body, std::span<const Vec3f> start, BodySample& s) {
  display_now(body, scratch_);
  if (scratch_.empty()) return;
  s.lowest = s.highest = scratch_.front().z();
  for (const Vec3f& x : scratch_) {
    s.center += x.cast<double>();
    s.lowest = std::min(s.lowest, static_cast<double>(x.z()));
    s.highest = std::max(s.highest, static_cast<double>(x.z()));
  }
  s.center /= static_cast<double>(scratch_.size());
  if (!start.empty()) s.tilt_degrees = angle_to_vertical(best_rotation(start, scratch_)(2, 2));
}

void Measures::sample(const World& world, const StepReport& frame) {
  for (std::size_t b = 0; b < samples_.size(); ++b) {
    const Body& body = world.body(static_cast<int>(b));
    BodySample s;
    if (posed_[b].vertices != nullptr)
      sample_posed(body, posed_[b], s);
    else
      sample_vertices(body, start_[b], s);
    if (std::isfinite(body.mass())) s.velocity = body.linear_momentum(world.v(static_cast<int>(b))) / body.mass();
    if (b < frame.impulse.size()) s.impulse = frame.impulse[b];
    samples_[b] = s;
  }
  for (const PairReport& pair : frame.pairs) {
    samples_[static_cast<std::size_t>(world.part(pair.part_a).body)].force += pair.force_on_a;
    samples_[static_cast<std::size_t>(world.part(pair.part_b).body)].force -= pair.force_on_a;
  }
}

void Measures::add(const World& world, const StepReport& frame, int steps) {
  sample(world, frame);
  keep(world, frame, steps, frame.warnings.size(), samples_);
}

void Measures::restore(const World& world, const StepReport& frame, int steps, std::size_t warnings,
                       std::span<const BodySample> bodies) {
  keep(world, frame, steps, warnings, bodies);
}

void Measures::keep(const World& world, const StepReport& frame, int steps, std::size_t warnings,
                    std::span<const BodySample> bodies) {
  MeasuredFrame f;
  f.index = frames_++;
  f.report = frame;
  f.report.impulse.clear();
  f.report.pairs.clear();
  f.report.links.clear();
  f.report.warnings.clear();
  f.steps = steps;
  f.warnings = warnings;
  for (const Watched& w : watched_) f.bodies.push_back(bodies[w.body]);
  for (const ShownMetric& m : shown_) f.shown.push_back(m.now(world));
  for (const SensorMetric& m : sensed_) f.sensed.push_back(m.now(world));
  for (int b = 0; asks_momentum_ && b < world.body_count(); ++b) {
    if (!std::isfinite(world.body(b).mass())) continue;
    f.momentum += world.body(b).linear_momentum(world.v(b));
    f.angular += world.body(b).angular_momentum(world.v(b));
  }
  if (f.index == 0) first_ = f;
  if (f.index == 1) {
    slack_ = 1e-3 * (f.report.time - first_.report.time);
    take(first_);
  }
  if (f.index > 0) take(f);
  last_ = std::move(f);
}

/// Adds a frame to the windows that contain it. A window has at least the first frame not before it.
void Measures::take(const MeasuredFrame& frame) {
  for (Asked& a : asked_) {
    const bool inside = a.begun ? frame.report.time <= end_of(a.expectation) + slack_
                                : frame.report.time >= a.expectation.from - slack_;
    if (inside) a.fold->add(frame);
    a.begun = a.begun || inside;
  }
}

ExpectationResult Measures::find(const Asked& a) const {
  const Expectation& e = a.expectation;
  ExpectationResult finding;
  finding.expectation = e;
  if (frames_ == 0) {
    finding.reached = false;
    return finding;
  }
  finding.reached = last_.report.time >= end_of(e) - slack_;
  std::unique_ptr<MetricFold> last_frame;
  if (!a.begun) {  // the last frame represents a window that the run did not reach
    last_frame = new_fold(a);
    last_frame->add(last_);
  }
  const std::vector<double> values = (a.begun ? a.fold : last_frame)->values();
  const auto within = [&](double x) { return x >= e.min && x <= e.max; };
  if (!MetricFold::about_bodies(e.metric)) {
    finding.value = values[0];
    if (a.shown >= 0) finding.body = e.body;
    if (a.sensed >= 0) finding.body = e.reading.sensor + "." + e.reading.channel;
    finding.ok = finding.reached && within(finding.value);
    return finding;
  }
  // Of several bodies the one closest to (or farthest beyond) a bound counts.
  double least_margin = std::numeric_limits<double>::infinity();
  bool all = true;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double x = values[i], margin = std::min(x - e.min, e.max - x);
    all = all && within(x);
    if (i == 0 || !(margin >= least_margin)) {
      least_margin = margin;
      finding.value = x;
      finding.body = watched_[a.watched[i]].name;
    }
  }
  finding.ok = finding.reached && !values.empty() && all;
  return finding;
}

std::vector<ExpectationResult> Measures::findings() const {
  std::vector<ExpectationResult> all;
  for (const Asked& a : asked_) all.push_back(find(a));
  return all;
}

}  // namespace brim
