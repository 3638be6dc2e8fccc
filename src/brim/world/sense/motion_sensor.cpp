#include "brim/world/sense/motion_sensor.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "brim/body/changing_surface.h"
#include "brim/body/solid_of.h"
#include "brim/core/error.h"
#include "brim/world/world.h"

namespace brim {

namespace {

/// [m] arms at whose ends the velocity is read for the spin.
constexpr double kSpinArm = 1.0;

Vec3 mean_shown(const Body& body, std::vector<Vec3f>& shown) {
  display_now(body, shown);
  Vec3 sum = Vec3::Zero();
  for (const Vec3f& x : shown) sum += x.cast<double>();
  return shown.empty() ? sum : Vec3(sum / static_cast<double>(shown.size()));
}

}  // namespace

MotionSensor::MotionSensor(const SensorModel& model, const World& world) : Sensor(model) {
  number_ = only_body(world, model.bodies);
  body_ = &world.body(number_);
  solid_ = body_->part_count() > 0 && solid_of(*body_, 0) != nullptr;
  if (model.point || solid_) {
    const Vec3 x = model.point ? *model.point : mean_shown(*body_, shown_);
    std::vector<Vec3> points = {x};
    if (solid_)
      points.insert(points.end(),
                    {x + kSpinArm * Vec3::UnitX(), x + kSpinArm * Vec3::UnitY(), x + kSpinArm * Vec3::UnitZ()});
    points_.emplace(world, number_, model.part, std::move(points));
  } else if (!std::isfinite(body_->mass())) {
    throw InputError(
        fmt::format("'{}' ({}) has no motion as a whole; give a \"point\" of it", body_->name(), body_->kind()));
  }
  add_axes(channels_, "position", "m", Taking::Last);
  add_axes(channels_, "velocity", "m/s", Taking::Last);
  channels_.push_back({"speed", "m/s", Taking::Last});
  add_axes(channels_, "acceleration", "m/s2", Taking::Mean);
  if (solid_) add_axes(channels_, "spin", "rad/s", Taking::Last);
  before_ = now(world).u;
}

void MotionSensor::find_bodies(const World& world) {
  if (points_) points_->find_body(world);
  number_ = -1;
  for (int b = 0; b < world.body_count(); ++b)
    if (&world.body(b) == body_) number_ = b;
}

MotionSensor::State MotionSensor::now(const World& world) {
  State s{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  const bool whole = !model_.point && std::isfinite(body_->mass());
  if (points_) {
    const auto x = points_->positions(world), u = points_->velocities(world);
    s.x = x[0], s.u = u[0];
    // With the present arms d: ω = ½ Σ d × (u(x + d) − u(x)) / |d|².
    for (std::size_t i = 1; i < x.size(); ++i)
      s.spin += 0.5 * (x[i] - x[0]).cross(u[i] - u[0]) / (x[i] - x[0]).squaredNorm();
  }
  if (!points_) s.x = mean_shown(*body_, shown_);
  if (whole) s.u = body_->linear_momentum(world.v(number_)) / body_->mass();
  return s;
}

void MotionSensor::begin_step(const World& world) {
  if (number_ >= 0 && !world.removed(number_)) before_ = now(world).u;
}

void MotionSensor::read(const World& world, const StepReport& report, std::span<double> values, std::span<double>) {
  if (number_ < 0 || world.removed(number_)) {
    std::fill(values.begin(), values.end(), std::numeric_limits<double>::quiet_NaN());
    return;
  }
  const State s = now(world);
  const Vec3 a = report.dt > 0.0 ? Vec3((s.u - before_) / report.dt) : Vec3::Zero();
  const double speed = s.u.norm();
  std::size_t at = 0;
  for (const Vec3& x : {s.x, s.u})
    std::copy(x.begin(), x.end(), values.begin() + static_cast<std::ptrdiff_t>(at)), at += 3;
  values[at++] = speed;
  std::copy(a.begin(), a.end(), values.begin() + static_cast<std::ptrdiff_t>(at));
  if (solid_) std::copy(s.spin.begin(), s.spin.end(), values.begin() + static_cast<std::ptrdiff_t>(at + 3));
}

}  // namespace brim
