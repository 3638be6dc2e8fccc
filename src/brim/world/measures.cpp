#include "brim/world/measures.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "brim/body/changing_surface.h"
#include "brim/body/posed_display.h"
#include "brim/core/error.h"
#include "brim/math/svd3.h"
#include "brim/world/report_fields.h"

namespace brim {

namespace {

/// Rotation that carries the points a onto b best, both about their centres (Kabsch 1976).
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

using WorldMetric = double (*)(const StepReport&);

/// Metrics of the world that are the largest of a value over the window.
const std::map<std::string, WorldMetric>& largest_metrics() {
  static const std::map<std::string, WorldMetric> table = {
      {"worst_overlap", [](const StepReport& r) { return r.worst_overlap; }},
      {"max_speed", [](const StepReport& r) { return r.max_speed; }},
      {"kinetic_energy", [](const StepReport& r) { return r.kinetic_energy; }},
      {"momentum_error", [](const StepReport& r) { return r.momentum_error; }},
      {"angular_error", [](const StepReport& r) { return r.angular_error; }},
      {"contacts", [](const StepReport& r) { return static_cast<double>(r.contacts); }},
  };
  return table;
}

/// Metrics of the world at the end of the window.
const std::map<std::string, WorldMetric>& final_metrics() {
  static const std::map<std::string, WorldMetric> table = {
      {"final_speed", [](const StepReport& r) { return r.max_speed; }},
      {"final_kinetic_energy", [](const StepReport& r) { return r.kinetic_energy; }},
      {"stiffness", [](const StepReport& r) { return r.stiffness; }},
  };
  return table;
}

const std::vector<std::string> kOtherWorldMetrics = {
    "energy_rise",   "energy_growth", "momentum_change", "angular_momentum_change",
    "contact_share", "cg_iterations", "substeps",        "step_seconds",
    "warnings",      "failed_steps",  "particles",       "sensor"};
const std::vector<std::string> kBodyMetrics = {
    "position_x",   "position_y", "position_z", "displacement", "displacement_x",  "displacement_y",  "displacement_z",
    "tilt_degrees", "speed",      "speed_kept", "acceleration", "contact_force_x", "contact_force_y", "contact_force_z",
    "lowest",       "highest",    "drift",      "impulse_x",    "impulse_y",       "impulse_z"};

bool about_bodies(const std::string& metric) {
  return std::find(kBodyMetrics.begin(), kBodyMetrics.end(), metric) != kBodyMetrics.end();
}

/// @param up  cosine, R_zz of a rotation
double angle_to_vertical(double up) { return std::acos(std::clamp(up, -1.0, 1.0)) * 180.0 / std::numbers::pi; }

double total_energy(const StepReport& r) { return r.kinetic_energy + r.potential_energy + r.contact_energy; }

}  // namespace

bool concerns(const std::string& wanted, const std::string& name) {
  if (!name.starts_with(wanted)) return false;
  if (name.size() == wanted.size()) return true;
  return name[wanted.size()] == '.' && name.size() > wanted.size() + 1 &&
         std::all_of(name.begin() + static_cast<std::ptrdiff_t>(wanted.size()) + 1, name.end(),
                     [](char c) { return c >= '0' && c <= '9'; });
}

std::vector<std::string> Measures::metrics() {
  std::vector<std::string> all = kOtherWorldMetrics;
  for (const auto& [name, unused] : largest_metrics()) all.push_back(name);
  for (const auto& [name, unused] : final_metrics()) all.push_back(name);
  all.insert(all.end(), kBodyMetrics.begin(), kBodyMetrics.end());
  all.insert(all.end(), ShownMetric::names().begin(), ShownMetric::names().end());
  return all;
}

Measures::Measures(const World& world, std::vector<Expectation> expectations, double end)
    : expectations_(std::move(expectations)), end_(end) {
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
      if (body.v_size() > 6) particles_ += static_cast<double>(body.v_size()) / 3.0;
      // A surface that changes keeps no vertices by which a turn could be told.
      if (posed_[b].vertices == nullptr && !changing_surface(body)) display_now(body, start_[b]);
    }
    const auto asks = [&](const Expectation& e) {
      return about_bodies(e.metric) && (e.body.empty() ? movable : concerns(e.body, body.name()));
    };
    if (std::any_of(expectations_.begin(), expectations_.end(), asks)) watched_.push_back({body.name(), b, movable});
  }
  for (const Expectation& e : expectations_) {
    asks_momentum_ = asks_momentum_ || e.metric == "momentum_change" || e.metric == "angular_momentum_change";
    shown_of_.push_back(ShownMetric::knows(e.metric) ? static_cast<int>(shown_.size()) : -1);
    if (shown_of_.back() >= 0) shown_.emplace_back(world, e);
    sensed_of_.push_back(e.metric == "sensor" ? static_cast<int>(sensed_.size()) : -1);
    if (sensed_of_.back() >= 0) sensed_.emplace_back(world, e);
  }
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
  Frame f;
  f.report = frame;
  f.report.pairs.clear();
  f.report.pairs.shrink_to_fit();
  f.report.warnings.clear();
  f.report.warnings.shrink_to_fit();
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
  frames_.push_back(std::move(f));
}

Measures::Window Measures::window(const Expectation& e) const {
  const double to = std::isfinite(e.to) ? e.to : end_;
  // Times are sums of steps: a thousandth of a frame forgives their rounding.
  const double slack = frames_.size() > 1 ? 1e-3 * (frames_[1].report.time - frames_[0].report.time) : 0.0;
  Window w;
  w.reached = !frames_.empty() && frames_.back().report.time >= to - slack;
  while (w.first + 1 < frames_.size() && frames_[w.first].report.time < e.from - slack) ++w.first;
  w.last = frames_.empty() ? 0 : frames_.size() - 1;
  while (w.last > w.first && frames_[w.last].report.time > to + slack) --w.last;
  return w;
}

double Measures::world_metric(const std::string& metric, const Window& w) const {
  if (metric == "particles") return particles_;
  if (const auto it = final_metrics().find(metric); it != final_metrics().end())
    return it->second(frames_[w.last].report);
  if (const auto it = largest_metrics().find(metric); it != largest_metrics().end()) {
    double largest = -std::numeric_limits<double>::infinity();
    for (std::size_t i = w.first; i <= w.last; ++i) {
      const double x = it->second(frames_[i].report);
      // Not-a-number must not hide behind a comparison.
      if (std::isnan(x)) return x;
      largest = std::max(largest, x);
    }
    return largest;
  }
  if (metric == "momentum_change") return (frames_[w.last].momentum - frames_[w.first].momentum).norm();
  if (metric == "angular_momentum_change") return (frames_[w.last].angular - frames_[w.first].angular).norm();
  if (metric == "energy_growth") {
    double growth = 0.0, least = std::numeric_limits<double>::infinity();
    for (std::size_t i = std::min(std::max<std::size_t>(w.first, 1), w.last); i <= w.last; ++i) {
      const double now = total_energy(frames_[i].report);
      if (std::isnan(now)) return now;
      least = std::min(least, now);
      growth = std::max(growth, now - least);
    }
    return growth;
  }
  if (metric == "energy_rise") {
    // The first frame has no report of its own: the energy of the run's start is that after the first.
    const std::size_t first = std::min(std::max<std::size_t>(w.first, 1), w.last);
    double rise = 0.0;
    for (std::size_t i = first; i <= w.last; ++i)
      rise = std::max(rise, total_energy(frames_[i].report) - total_energy(frames_[first].report));
    return rise;
  }
  double above = 0.0, below = 0.0, sum = 0.0, most = 0.0;
  for (std::size_t i = w.first; i <= w.last; ++i) {
    const Frame& f = frames_[i];
    if (metric == "contact_share") {
      above += contact_seconds(f.report);
      below += f.report.wall;
    } else if (metric == "cg_iterations") {
      above += f.report.cg_iterations;
      below += f.report.solves;
    } else if (metric == "step_seconds") {
      above += f.report.wall;
      below += f.steps;
    } else if (metric == "substeps") {
      if (f.steps > 0) most = std::max(most, static_cast<double>(f.report.substeps) / f.steps);
    } else if (metric == "warnings") {
      sum += static_cast<double>(f.warnings);
    } else if (metric == "failed_steps") {
      sum += f.report.ok ? 0.0 : 1.0;
    } else {
      throw ProgrammingError("no such metric: " + metric);
    }
  }
  if (metric == "substeps") return most;
  if (metric == "warnings" || metric == "failed_steps") return sum;
  return below > 0.0 ? above / below : 0.0;
}

double Measures::shown_metric(std::size_t index, const Window& w) const {
  std::vector<double> values;
  for (std::size_t i = w.first; i <= w.last; ++i) values.push_back(frames_[i].shown[index]);
  return shown_[index].over(values);
}

double Measures::sensor_metric(std::size_t index, const Window& w) const {
  std::vector<SensorMetric::Pair> values;
  for (std::size_t i = w.first; i <= w.last; ++i) values.push_back(frames_[i].sensed[index]);
  return sensed_[index].over(values);
}

double Measures::body_metric(const std::string& metric, std::size_t i, const Window& w) const {
  const BodySample &a = frames_[w.first].bodies[i], &b = frames_[w.last].bodies[i];
  const Vec3 moved = b.center - a.center;
  const auto axis = [&] { return metric.back() - 'x'; };
  if (metric.starts_with("position_")) return b.center[axis()];
  if (metric == "displacement") return moved.norm();
  if (metric.starts_with("displacement_")) return moved[axis()];
  if (metric == "tilt_degrees") return b.tilt_degrees;
  if (metric == "speed") return b.velocity.norm();
  if (metric == "speed_kept") return b.velocity.norm() / a.velocity.norm();
  if (metric == "acceleration") {
    const double time = frames_[w.last].report.time - frames_[w.first].report.time;
    return (b.velocity - a.velocity).norm() / time;
  }
  double lowest = a.lowest, highest = a.highest, force = 0.0, drift = 0.0, impulse = 0.0;
  for (std::size_t f = w.first; f <= w.last; ++f) {
    const BodySample& s = frames_[f].bodies[i];
    lowest = std::min(lowest, s.lowest);
    highest = std::max(highest, s.highest);
    if (metric.starts_with("contact_force_")) force += s.force[axis()];
    drift = std::max(drift, (s.center - a.center).norm());
    if (f > w.first && metric.starts_with("impulse_"))
      impulse += s.force[axis()] * (frames_[f].report.time - frames_[f - 1].report.time);
  }
  if (metric == "lowest") return lowest;
  if (metric == "highest") return highest;
  if (metric == "drift") return drift;
  if (metric.starts_with("impulse_")) return impulse;
  if (metric.starts_with("contact_force_")) return force / static_cast<double>(w.last - w.first + 1);
  throw ProgrammingError("no such metric: " + metric);
}

Finding Measures::find(std::size_t expectation) const {
  const Expectation& e = expectations_[expectation];
  Finding finding;
  finding.expectation = e;
  const Window w = window(e);
  finding.reached = w.reached;
  if (frames_.empty()) return finding;
  const auto within = [&](double x) { return x >= e.min && x <= e.max; };
  if (!about_bodies(e.metric)) {
    const int shown = shown_of_[expectation], sensed = sensed_of_[expectation];
    finding.value = shown >= 0    ? shown_metric(static_cast<std::size_t>(shown), w)
                    : sensed >= 0 ? sensor_metric(static_cast<std::size_t>(sensed), w)
                                  : world_metric(e.metric, w);
    if (shown >= 0) finding.body = e.body;
    if (sensed >= 0) finding.body = e.reading.sensor + "." + e.reading.channel;
    finding.ok = w.reached && within(finding.value);
    return finding;
  }
  // Of several bodies the one nearest to (or farthest beyond) a bound speaks for all.
  double least_margin = std::numeric_limits<double>::infinity();
  bool all = true, any = false;
  for (std::size_t i = 0; i < watched_.size(); ++i) {
    if (e.body.empty() ? !watched_[i].movable : !concerns(e.body, watched_[i].name)) continue;
    const double x = body_metric(e.metric, i, w);
    const double margin = std::min(x - e.min, e.max - x);
    all = all && within(x);
    if (!any || !(margin >= least_margin)) {
      least_margin = margin;
      finding.value = x;
      finding.body = watched_[i].name;
    }
    any = true;
  }
  finding.ok = w.reached && any && all;
  return finding;
}

std::vector<Finding> Measures::findings() const {
  std::vector<Finding> all;
  for (std::size_t i = 0; i < expectations_.size(); ++i) all.push_back(find(i));
  return all;
}

}  // namespace brim
