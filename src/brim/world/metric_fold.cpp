#include "brim/world/metric_fold.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "brim/core/error.h"
#include "brim/world/number_fold.h"
#include "brim/world/report_fields.h"

namespace brim {

namespace {

using Take = NumberFold::Take;
using Quantity = double (*)(const MeasuredFrame&);

/// Metrics that are one quantity per frame, accumulated.
struct SimpleMetric {
  Take take;
  Quantity of;
};

const std::map<std::string, SimpleMetric>& simple_metrics() {
  using Frame = MeasuredFrame;
  static const std::map<std::string, SimpleMetric> table = {
      {"worst_overlap", {Take::Largest, [](const Frame& f) { return f.report.worst_overlap; }}},
      {"max_speed", {Take::Largest, [](const Frame& f) { return f.report.max_speed; }}},
      {"kinetic_energy", {Take::Largest, [](const Frame& f) { return f.report.kinetic_energy; }}},
      {"momentum_error", {Take::Largest, [](const Frame& f) { return f.report.momentum_error; }}},
      {"angular_error", {Take::Largest, [](const Frame& f) { return f.report.angular_error; }}},
      {"contacts", {Take::Largest, [](const Frame& f) { return static_cast<double>(f.report.contacts); }}},
      {"substeps",
       {Take::Largest,
        [](const Frame& f) { return f.steps > 0 ? static_cast<double>(f.report.substeps) / f.steps : 0.0; }}},
      {"final_speed", {Take::Last, [](const Frame& f) { return f.report.max_speed; }}},
      {"final_kinetic_energy", {Take::Last, [](const Frame& f) { return f.report.kinetic_energy; }}},
      {"stiffness", {Take::Last, [](const Frame& f) { return f.report.stiffness; }}},
      {"warnings", {Take::Sum, [](const Frame& f) { return static_cast<double>(f.warnings); }}},
      {"failed_steps", {Take::Sum, [](const Frame& f) { return f.report.ok ? 0.0 : 1.0; }}},
  };
  return table;
}

/// Metrics that are the ratio of two summed quantities.
struct RatioMetric {
  Quantity above, below;
};

const std::map<std::string, RatioMetric>& ratio_metrics() {
  using Frame = MeasuredFrame;
  static const std::map<std::string, RatioMetric> table = {
      {"contact_share",
       {[](const Frame& f) { return contact_seconds(f.report); }, [](const Frame& f) { return f.report.wall; }}},
      {"cg_iterations",
       {[](const Frame& f) { return static_cast<double>(f.report.cg_iterations); },
        [](const Frame& f) { return static_cast<double>(f.report.solves); }}},
      {"step_seconds",
       {[](const Frame& f) { return f.report.wall; }, [](const Frame& f) { return static_cast<double>(f.steps); }}},
  };
  return table;
}

const std::vector<std::string> kBodyMetrics = {
    "position_x",   "position_y", "position_z", "displacement", "displacement_x",  "displacement_y",  "displacement_z",
    "tilt_degrees", "speed",      "speed_kept", "acceleration", "contact_force_x", "contact_force_y", "contact_force_z",
    "lowest",       "highest",    "drift",      "impulse_x",    "impulse_y",       "impulse_z"};

double total_energy(const StepReport& r) { return r.kinetic_energy + r.potential_energy + r.contact_energy; }

class SimpleFold : public MetricFold {
 public:
  explicit SimpleFold(const SimpleMetric& m) : of_(m.of), fold_(m.take) {}
  void add(const MeasuredFrame& f) override { fold_.add(of_(f)); }
  std::vector<double> values() const override { return {fold_.value()}; }

 private:
  Quantity of_;
  NumberFold fold_;
};

class RatioFold : public MetricFold {
 public:
  explicit RatioFold(const RatioMetric& m) : of_(m) {}
  void add(const MeasuredFrame& f) override { above_ += of_.above(f), below_ += of_.below(f); }
  std::vector<double> values() const override { return {below_ > 0.0 ? above_ / below_ : 0.0}; }

 private:
  RatioMetric of_;
  double above_ = 0.0, below_ = 0.0;
};

class ConstantFold : public MetricFold {
 public:
  explicit ConstantFold(double value) : value_(value) {}
  void add(const MeasuredFrame&) override {}
  std::vector<double> values() const override { return {value_}; }

 private:
  double value_;
};

/// Change of a vector from the start of the window to its end.
class ChangeFold : public MetricFold {
 public:
  explicit ChangeFold(Vec3 MeasuredFrame::*of) : of_(of) {}
  void add(const MeasuredFrame& f) override {
    last_ = f.*of_;
    if (std::exchange(empty_, false)) first_ = last_;
  }
  std::vector<double> values() const override { return {(last_ - first_).norm()}; }

 private:
  Vec3 MeasuredFrame::*of_;
  bool empty_ = true;
  Vec3 first_ = Vec3::Zero(), last_ = Vec3::Zero();
};

/// Largest energy relative to an earlier one: that of the window's start (rise), or the least before (growth). The
/// run's first frame has no report: the energy at the start of the run is that after its first step.
class EnergyFold : public MetricFold {
 public:
  explicit EnergyFold(bool over_least) : over_least_(over_least) {}
  void add(const MeasuredFrame& f) override {
    if (f.index == 0) return;
    const double now = total_energy(f.report);
    if (std::exchange(empty_, false)) from_ = now;
    if (over_least_) from_ = std::min(from_, now);
    largest_.add(now - from_);
  }
  std::vector<double> values() const override { return {empty_ ? 0.0 : largest_.value()}; }

 private:
  bool over_least_;
  bool empty_ = true;
  double from_ = 0.0;  // [J]
  NumberFold largest_{Take::Largest};
};

class BodyFold : public MetricFold {
 public:
  BodyFold(const std::string& metric, std::vector<std::size_t> bodies)
      : bodies_(std::move(bodies)), axis_(metric.back() - 'x') {
    static const std::pair<const char*, Of> kinds[] = {{"position_", Of::Position},
                                                       {"displacement_", Of::DisplacementAlong},
                                                       {"displacement", Of::Displacement},
                                                       {"tilt_degrees", Of::Tilt},
                                                       {"speed_kept", Of::SpeedKept},
                                                       {"speed", Of::Speed},
                                                       {"acceleration", Of::Acceleration},
                                                       {"contact_force_", Of::Force},
                                                       {"lowest", Of::Lowest},
                                                       {"highest", Of::Highest},
                                                       {"drift", Of::Drift},
                                                       {"impulse_", Of::Impulse}};
    const auto kind = std::ranges::find_if(kinds, [&](const auto& k) { return metric.starts_with(k.first); });
    of_ = kind->second;
    const Take take = of_ == Of::Force                         ? Take::Mean
                      : of_ == Of::Impulse                     ? Take::SumAfterFirst
                      : of_ == Of::Lowest                      ? Take::Least
                      : of_ == Of::Highest || of_ == Of::Drift ? Take::Largest
                                                               : Take::Last;
    folds_.assign(bodies_.size(), NumberFold(take));
  }

  void add(const MeasuredFrame& f) override {
    if (start_.empty()) {
      first_ = f.report.time;
      for (const std::size_t b : bodies_)
        start_.push_back(of_ == Of::SpeedKept || of_ == Of::Acceleration ? f.bodies[b].velocity : f.bodies[b].center);
    }
    for (std::size_t i = 0; i < bodies_.size(); ++i) folds_[i].add(now(f.bodies[bodies_[i]], start_[i], f.report));
  }

  std::vector<double> values() const override {
    std::vector<double> all;
    for (const NumberFold& f : folds_) all.push_back(f.value());
    return all;
  }

 private:
  enum class Of {
    Position,
    Displacement,
    DisplacementAlong,
    Tilt,
    Speed,
    SpeedKept,
    Acceleration,
    Force,
    Lowest,
    Highest,
    Drift,
    Impulse
  };

  /// @param start  centre of the body at the window's start, or its velocity
  double now(const BodySample& s, const Vec3& start, const StepReport& report) const {
    switch (of_) {
      case Of::Position:
        return s.center[axis_];
      case Of::Displacement:
      case Of::Drift:
        return (s.center - start).norm();
      case Of::DisplacementAlong:
        return s.center[axis_] - start[axis_];
      case Of::Tilt:
        return s.tilt_degrees;
      case Of::Speed:
        return s.velocity.norm();
      case Of::SpeedKept:
        return s.velocity.norm() / start.norm();
      case Of::Acceleration:
        return (s.velocity - start).norm() / (report.time - first_);
      case Of::Force:
        return report.dt > 0.0 ? s.impulse[axis_] / report.dt : 0.0;  // the first frame has no step
      case Of::Lowest:
        return s.lowest;
      case Of::Highest:
        return s.highest;
      case Of::Impulse:
        return s.impulse[axis_];
    }
    return std::numeric_limits<double>::quiet_NaN();
  }

  std::vector<std::size_t> bodies_;
  int axis_;  ///< of metrics that end in _x, _y or _z
  Of of_ = Of::Position;
  double first_ = 0.0;             ///< [s] time of the window's start
  std::vector<Vec3> start_;        ///< shape (bodies_); empty before the first frame
  std::vector<NumberFold> folds_;  ///< shape (bodies_)
};

class ShownFold : public MetricFold {
 public:
  ShownFold(const ShownMetric& m, std::size_t index) : index_(index), fold_(m.take()) {}
  void add(const MeasuredFrame& f) override { fold_.add(f.shown[index_]); }
  std::vector<double> values() const override { return {fold_.value()}; }

 private:
  std::size_t index_;
  NumberFold fold_;
};

class SensorFold : public MetricFold {
 public:
  SensorFold(const SensorMetric& m, std::size_t index) : index_(index), fold_(m.fold()) {}
  void add(const MeasuredFrame& f) override { fold_.add(f.sensed[index_]); }
  std::vector<double> values() const override { return {fold_.value()}; }

 private:
  std::size_t index_;
  SensorMetric::Fold fold_;
};

}  // namespace

bool MetricFold::about_bodies(const std::string& metric) {
  return std::ranges::find(kBodyMetrics, metric) != kBodyMetrics.end();
}

std::vector<std::string> MetricFold::metrics() {
  std::vector<std::string> all = {"energy_rise", "energy_growth", "momentum_change", "angular_momentum_change",
                                  "particles",   "sensor"};
  for (const auto& [name, unused] : simple_metrics()) all.push_back(name);
  for (const auto& [name, unused] : ratio_metrics()) all.push_back(name);
  all.insert(all.end(), kBodyMetrics.begin(), kBodyMetrics.end());
  return all;
}

std::unique_ptr<MetricFold> MetricFold::of_world(const std::string& metric, double particles) {
  if (const auto it = simple_metrics().find(metric); it != simple_metrics().end())
    return std::make_unique<SimpleFold>(it->second);
  if (const auto it = ratio_metrics().find(metric); it != ratio_metrics().end())
    return std::make_unique<RatioFold>(it->second);
  if (metric == "energy_rise" || metric == "energy_growth")
    return std::make_unique<EnergyFold>(metric == "energy_growth");
  if (metric == "momentum_change") return std::make_unique<ChangeFold>(&MeasuredFrame::momentum);
  if (metric == "angular_momentum_change") return std::make_unique<ChangeFold>(&MeasuredFrame::angular);
  if (metric == "particles") return std::make_unique<ConstantFold>(particles);
  throw ProgrammingError("no such metric: " + metric);
}

std::unique_ptr<MetricFold> MetricFold::of_bodies(const std::string& metric, std::vector<std::size_t> bodies) {
  return std::make_unique<BodyFold>(metric, std::move(bodies));
}

std::unique_ptr<MetricFold> MetricFold::of_shown(const ShownMetric& metric, std::size_t index) {
  return std::make_unique<ShownFold>(metric, index);
}

std::unique_ptr<MetricFold> MetricFold::of_sensor(const SensorMetric& metric, std::size_t index) {
  return std::make_unique<SensorFold>(metric, index);
}

}  // namespace brim
