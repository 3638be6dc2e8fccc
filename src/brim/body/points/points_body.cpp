#include "brim/body/points/points_body.h"

#include <algorithm>
#include <numbers>

#include "brim/body/particles/ball_contact.h"
#include "brim/core/error.h"
#include "brim/core/parallel.h"

namespace brim {

namespace {

std::vector<double> radii_of(std::size_t grains, const PointsOptions& o) {
  if (grains == 0) throw InputError("points: there is no grain");
  if (o.radius.size() != 1 && o.radius.size() != grains)
    throw InputError(
        fmt::format("points: {} radii for {} grains; give one for each, or one for all", o.radius.size(), grains));
  for (const double r : o.radius) require_positive("points", "radius", r);
  require_positive("points", "density", o.density);
  require_positive("points", "Young's modulus", o.young);
  require_not_negative("points", "friction", o.friction);
  require_positive("points", "slip speed", o.slip_speed);
  require_not_negative("points", "gravity", o.gravity);
  return o.radius.size() == 1 ? std::vector<double>(grains, o.radius[0]) : o.radius;
}

std::vector<double> masses_of(std::span<const double> radius, double density) {
  std::vector<double> mass;
  for (const double r : radius) mass.push_back(density * 4.0 / 3.0 * std::numbers::pi * r * r * r);
  return mass;
}

}  // namespace

PointsBody::PointsBody(std::vector<Vec3> centers, PointsOptions options)
    : PointsBody(centers, radii_of(centers.size(), options), options) {}

PointsBody::PointsBody(std::vector<Vec3> centers, std::vector<double> radius, const PointsOptions& options)
    : ParticleBody(std::move(centers), masses_of(radius, options.density), options),
      radius_(std::move(radius)),
      material_{options.young, options.friction, options.stiffness_damping, options.gravity, options.slip_speed} {
  stiffness_.begin(particle_count());
  stiffness_.finish();
  force_.assign(particle_count(), Vec3::Zero());
  pair_force_ = force_;

  double total = 0.0, mean = 0.0;
  for (const double m : mass_) total += m;
  for (const double r : radius_) mean += r / static_cast<double>(radius_.size());
  const double smallest = *std::min_element(radius_.begin(), radius_.end());
  auto contact = std::make_unique<BallContact>(radius_);
  // The column behind the contact: all grains over their smallest footprint, or one grain.
  Aabb box;
  for (const Vec3& x : rest_) box.extend(x);
  const Vec3 extent = box.extent() + Vec3::Constant(2.0 * contact->reach());
  PartInfo part;
  part.voxel_size = smallest / 1.5;
  part.areal_mass = total * extent.maxCoeff() / extent.prod();
  part.thickness = 2.0 * smallest;
  part.modulus = options.young;
  set_contact(std::move(contact), part);
  display_.kind = Display::Kind::Points;
  display_.radius = mean;
}

double PointsBody::gap_for(double dt) const {
  Vec3 middle = Vec3::Zero();
  for (const Vec3& v : v_) middle += v / static_cast<double>(v_.size());
  double speed = 0.0;
  for (const Vec3& v : v_) speed = std::max(speed, (v - middle).norm());
  const double largest = *std::max_element(radius_.begin(), radius_.end());
  return std::min(2.0 * dt * speed, 2.0 * largest);
}

void PointsBody::add_inner() {
  // The step to come is as long as the last, most often; then the pairs are good for begin_solve also.
  pairs_.find(x_, radius_, gap_for(dt_));
  pairs_.evaluate(x_, v_, radius_, mass_, material_, 0.0);
  pairs_.add_forces(force_);
  pair_force_ = force_;
}

void PointsBody::begin_solve(double dt) {
  ParticleBody::begin_solve(dt);
  const double gap = gap_for(dt);
  if (gap > pairs_.gap()) pairs_.find(x_, radius_, gap);
  pairs_.evaluate(x_, v_, radius_, mass_, material_, dt);
  std::fill(pair_force_.begin(), pair_force_.end(), Vec3::Zero());
  pairs_.add_forces(pair_force_);
}

void PointsBody::add_forces(const Environment& env, std::span<double> Q) const {
  for (std::size_t i = 0; i < mass_.size(); ++i)
    Eigen::Map<Vec3>(Q.data() + 3 * i) += mass_[i] * (env.gravity - options_.mass_damping * v_[i]) + pair_force_[i];
  add_outer_forces(Q);
}

void PointsBody::apply_stiffness(std::span<const double> x, std::span<double> y) const {
  pairs_.multiply_add(-1.0, 0.0, x, y);
}

void PointsBody::apply_damping(std::span<const double> x, std::span<double> y) const {
  stiffness_.multiply_add(0.0, -options_.mass_damping, mass_, x, y);
  pairs_.multiply_add(0.0, -1.0, x, y);
}

void PointsBody::apply_system(std::span<const double> x, std::span<double> y) const {
  stiffness_.multiply_add(0.0, 1.0 + dt_ * options_.mass_damping, mass_, x, y);
  pairs_.multiply_add(dt_ * dt_, dt_, x, y);
}

void PointsBody::add_system_diagonal(std::size_t first, BlockDiagonal& D) const {
  const double b = 1.0 + dt_ * options_.mass_damping;
  parallel_blocks(mass_.size(), 512, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      D.block(first + i) += b * mass_[i] * Mat3::Identity() + pairs_.diagonal(i, dt_ * dt_, dt_);
  });
}

}  // namespace brim
