#include "brim/world/sense/strain_sensor.h"

#include <algorithm>
#include <limits>

#include "brim/body/changing_surface.h"
#include "brim/core/error.h"
#include "brim/math/small_symmetric.h"
#include "brim/world/world.h"

namespace brim {

namespace {

/// Extent of a region along a direction, relative to its largest, below which it does not span the direction.
constexpr double kFlat = 1e-3;

}  // namespace

StrainSensor::StrainSensor(const SensorModel& model, const World& world) : Sensor(model) {
  body_ = only_body(world, model.bodies);
  const Body& body = world.body(body_);
  shown_ = &body;
  if (!model.region) throw InputError("strain is that of a region; none is given");
  if (changing_surface(body) || body.part(0).conforming)
    throw InputError(fmt::format("'{}' ({}) has no vertices that stay with its matter", body.name(), body.kind()));
  display_now(body, position_);
  for (std::size_t i = 0; i < position_.size(); ++i)
    if (model.region(position_[i].cast<double>())) vertex_.push_back(i);
  if (vertex_.size() < 2)
    throw InputError(
        fmt::format("{} vertices of '{}' lie in the region; strain needs two or more", vertex_.size(), body.name()));
  places(start_);
  Mat3 spread = Mat3::Zero();
  for (const Vec3& p : start_) spread += p * p.transpose();
  const SymmetricAxes axes = symmetric_axes(spread);
  const double most = axes.values.maxCoeff();
  if (!(most > 0.0)) throw InputError("the vertices of the region lie at one place");
  for (int i = 0; i < 3; ++i) {
    if (!(axes.values[i] > kFlat * kFlat * most)) continue;
    const Vec3 d = axes.vectors.col(i);
    inverse_ += d * d.transpose() / axes.values[i];
    projection_ += d * d.transpose();
  }
  for (const char* entry : {"xx", "yy", "zz", "xy", "xz", "yz"})
    channels_.push_back({std::string("strain_") + entry, "", Taking::Last});
  channels_.push_back({"largest", "", Taking::Last});
  channels_.push_back({"least", "", Taking::Last});
}

void StrainSensor::find_bodies(const World& world) {
  body_ = -1;
  for (int b = 0; b < world.body_count(); ++b)
    if (&world.body(b) == shown_) body_ = b;
}

void StrainSensor::places(std::vector<Vec3>& x) {
  display_now(*shown_, position_);
  x.resize(vertex_.size());
  Vec3 mean = Vec3::Zero();
  for (std::size_t i = 0; i < x.size(); ++i) mean += x[i] = position_[vertex_[i]].cast<double>();
  mean /= static_cast<double>(x.size());
  for (Vec3& p : x) p -= mean;
}

void StrainSensor::read(const World& world, const StepReport&, std::span<double> values, std::span<double>) {
  if (body_ < 0 || world.removed(body_)) {
    std::fill(values.begin(), values.end(), std::numeric_limits<double>::quiet_NaN());
    return;
  }
  places(now_);
  Mat3 moment = Mat3::Zero();
  for (std::size_t i = 0; i < now_.size(); ++i) moment += now_[i] * start_[i].transpose();
  const Mat3 F = moment * inverse_;
  const Mat3 E = 0.5 * (F.transpose() * F - projection_);
  // Principal strains within the span of the region; E is zero perpendicular to it.
  const SymmetricAxes axes = symmetric_axes(E);
  double largest = -std::numeric_limits<double>::infinity(), least = -largest;
  for (int i = 0; i < 3; ++i) {
    const Vec3 d = axes.vectors.col(i);
    if (d.dot(projection_ * d) < 0.5) continue;
    largest = std::max(largest, axes.values[i]), least = std::min(least, axes.values[i]);
  }
  const double all[] = {E(0, 0), E(1, 1), E(2, 2), E(0, 1), E(0, 2), E(1, 2), largest, least};
  std::copy(std::begin(all), std::end(all), values.begin());
}

DistanceSensor::DistanceSensor(const SensorModel& model, const World& world) : Sensor(model) {
  if (!model.point || !model.to_point) throw InputError("a distance is between a point and another one; give both");
  a_.emplace(world, only_body(world, model.bodies), model.part, std::vector<Vec3>{*model.point});
  if (!model.to.empty()) b_.emplace(world, only_body(world, {model.to}), -1, std::vector<Vec3>{*model.to_point});
  const Vec3 b = b_ ? b_->positions(world)[0] : *model.to_point;
  start_ = (a_->positions(world)[0] - b).norm();
  if (!(start_ > 0.0)) throw InputError("the two points lie at one place");
  channels_ = {{"distance", "m", Taking::Last}, {"strain", "", Taking::Last}, {"rate", "m/s", Taking::Last}};
}

void DistanceSensor::find_bodies(const World& world) {
  a_->find_body(world);
  if (b_) b_->find_body(world);
}

void DistanceSensor::read(const World& world, const StepReport&, std::span<double> values, std::span<double>) {
  if (!a_->present(world) || (b_ && !b_->present(world))) {
    std::fill(values.begin(), values.end(), std::numeric_limits<double>::quiet_NaN());
    return;
  }
  const Vec3 a = a_->positions(world)[0], b = b_ ? b_->positions(world)[0] : *model_.to_point;
  const Vec3 u = a_->velocities(world)[0] - (b_ ? b_->velocities(world)[0] : Vec3(Vec3::Zero()));
  const double length = (a - b).norm();
  values[0] = length;
  values[1] = length / start_ - 1.0;
  values[2] = length > 0.0 ? u.dot(a - b) / length : u.norm();
}

}  // namespace brim
