#include "brim/body/points/points_body.h"

#include <algorithm>
#include <numbers>

#include "brim/body/particles/ball_contact.h"
#include "brim/body/particles/loose_clusters.h"
#include "brim/core/error.h"
#include "brim/core/parallel.h"

namespace brim {

namespace {

/// Inertia of a grain that does not turn, over its own, as preconditioners see it.
constexpr double kNoTurn = 1e12;
/// Overlap at the end of a step, over the smallest radius, for which pairs are not searched anew.
constexpr double kUnsearched = 0.01;

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
  require_not_negative("points", "rolling friction", o.rolling_friction);
  require_not_negative("points", "gravity", o.gravity);
  return o.radius.size() == 1 ? std::vector<double>(grains, o.radius[0]) : o.radius;
}

Eigen::Map<const Vec3> three(std::span<const double> a, std::size_t i) {
  return Eigen::Map<const Vec3>(a.data() + 3 * i);
}
Eigen::Map<Vec3> three(std::span<double> a, std::size_t i) { return Eigen::Map<Vec3>(a.data() + 3 * i); }

/// The velocities of the centres, shape (3 grains).
std::vector<double> centers_alone(std::span<const double> v) {
  std::vector<double> out(v.size() / 2);
  for (std::size_t i = 0; i < out.size() / 3; ++i) three(std::span(out), i) = three(v, 2 * i);
  return out;
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
      smallest_(*std::min_element(radius_.begin(), radius_.end())),
      largest_(*std::max_element(radius_.begin(), radius_.end())),
      material_{options.young,   options.friction,  options.rolling_friction, options.stiffness_damping,
                options.gravity, options.slip_speed} {
  stiffness_.begin(particle_count());
  stiffness_.finish();
  force_.assign(particle_count(), Vec3::Zero());
  turn_ = options.turn;
  pair_force_ = pair_torque_ = spin_ = force_;
  roll_.assign(particle_count(), 0.0);
  for (std::size_t i = 0; i < mass_.size(); ++i) inertia_.push_back(0.4 * mass_[i] * radius_[i] * radius_[i]);

  std::vector<std::uint8_t> is_given(radius_.size(), 0);
  for (const std::int32_t i : prescribed_) is_given[static_cast<std::size_t>(i)] = 1;
  for (std::size_t i = 0; i < radius_.size(); ++i) {
    if (is_given[i]) given_.push_back(static_cast<std::int32_t>(2 * i));
    if (is_given[i] || !turn_) given_.push_back(static_cast<std::int32_t>(2 * i + 1));
  }

  double total = 0.0, mean = 0.0;
  for (const double m : mass_) total += m;
  for (const double r : radius_) mean += r / static_cast<double>(radius_.size());
  auto contact = std::make_unique<BallContact>(radius_);
  // The column behind the contact: all grains over their smallest footprint, or one grain.
  Aabb box;
  for (const Vec3& x : rest_) box.extend(x);
  const Vec3 extent = box.extent() + Vec3::Constant(2.0 * contact->reach());
  PartInfo part;
  part.voxel_size = smallest_ / 1.5;
  part.areal_mass = total * extent.maxCoeff() / extent.prod();
  part.thickness = part.width = 2.0 * smallest_;
  part.modulus = options.young;
  set_contact(std::move(contact), part);
  display_.kind = Display::Kind::Points;
  display_.radius = mean;
}

double PointsBody::gap_for(double dt, std::span<const Vec3> v) const {
  Vec3 middle = Vec3::Zero();
  for (const Vec3& vi : v) middle += vi / static_cast<double>(v.size());
  double speed = 0.0;
  for (const Vec3& vi : v) speed = std::max(speed, (vi - middle).norm());
  return std::min(2.0 * dt * speed, 2.0 * largest_);
}

void PointsBody::initial_state(std::span<double> q, std::span<double> v) const {
  Vec3 center = Vec3::Zero();
  double total = 0.0;
  for (std::size_t i = 0; i < mass_.size(); ++i) center += mass_[i] * rest_[i], total += mass_[i];
  center /= total;
  for (std::size_t i = 0; i < mass_.size(); ++i) {
    three(q, i) = rest_[i];
    three(v, 2 * i) = options_.initial_velocity + options_.initial_spin.cross(rest_[i] - center);
    three(v, 2 * i + 1) = options_.initial_spin;
  }
  filter(v);
}

void PointsBody::prescribe(double time, double dt, std::span<const double> q, std::span<double> v) const {
  filter(v);
  for (const NodeMotion& m : options_.motions)
    for (const std::int32_t i : m.nodes) {
      const auto k = static_cast<std::size_t>(i);
      three(v, 2 * k) = (m.position(time + dt, rest_[k]) - three(q, k)) / dt;
    }
}

void PointsBody::update(double time, std::span<const double> q, std::span<const double> v) {
  BRIM_CHECK(v.size(), ==, v_size());
  for (std::size_t i = 0; i < spin_.size(); ++i) spin_[i] = three(v, 2 * i + 1);
  ParticleBody::update(time, q, centers_alone(v));
  cells_.build(x_, 4.0 * largest_);
}

void PointsBody::advance(double dt, std::span<double> q, std::span<const double> v) const {
  for (std::size_t i = 0; i < mass_.size(); ++i) three(q, i) += dt * three(v, 2 * i);
}

void PointsBody::move(const Pose& by, std::span<double> q, std::span<double> v) const {
  for (std::size_t i = 0; i < mass_.size(); ++i) three(q, i) = by.rotation * three(q, i) + by.translation;
  for (std::size_t i = 0; i < 2 * mass_.size(); ++i) three(v, i) = by.rotation * three(v, i);
}

void PointsBody::add_inner() {
  // The step to come is as long as the last, most often; then the pairs are good for begin_solve also.
  pairs_.find(x_, radius_, gap_for(dt_, v_));
  pairs_.evaluate(x_, v_, spin_, radius_, mass_, material_, 0.0);
  std::fill(pair_torque_.begin(), pair_torque_.end(), Vec3::Zero());
  pairs_.add_forces(force_, pair_torque_);
  pair_force_ = force_;
}

void PointsBody::begin_solve(double dt) {
  ParticleBody::begin_solve(dt);
  find_pairs(gap_for(dt, v_));
  gather_pairs();
  roll_.assign(mass_.size(), 0.0);
  for (std::size_t i = 0; i < load_.size(); ++i)
    roll_[i] = material_.rolling * radius_[i] * load_[i] / std::max(spin_[i].norm(), material_.slip_speed / radius_[i]);
  load_.clear();
}

void PointsBody::find_pairs(double gap) {
  if (gap > pairs_.gap()) pairs_.find(x_, radius_, gap);
  pairs_.evaluate(x_, v_, spin_, radius_, mass_, material_, dt_);
}

void PointsBody::gather_pairs() {
  std::fill(pair_force_.begin(), pair_force_.end(), Vec3::Zero());
  std::fill(pair_torque_.begin(), pair_torque_.end(), Vec3::Zero());
  pairs_.add_forces(pair_force_, pair_torque_);
  pairs_.couple(dt_ * dt_, dt_);
}

bool PointsBody::foresee(std::span<const double> v) {
  std::vector<Vec3> after(mass_.size()), spin(mass_.size());
  for (std::size_t i = 0; i < after.size(); ++i) after[i] = three(v, 2 * i), spin[i] = three(v, 2 * i + 1);
  const double gap = gap_for(dt_, after);
  // With room for later solves: pairs found anew forget what was foreseen before.
  if (gap > pairs_.gap() + kUnsearched * smallest_) find_pairs(2.0 * gap);
  if (!pairs_.foresee(after, spin, x_, v_, spin_, radius_, mass_, material_, dt_)) return false;
  gather_pairs();
  return true;
}

void PointsBody::add_forces(const Environment& env, std::span<double> Q) const {
  for (std::size_t i = 0; i < mass_.size(); ++i) {
    three(Q, 2 * i) += mass_[i] * (env.gravity - options_.mass_damping * v_[i]) + pair_force_[i];
    three(Q, 2 * i + 1) += pair_torque_[i] - (options_.mass_damping * inertia_[i] + roll_[i]) * spin_[i];
  }
  add_outer_forces(Q);
}

void PointsBody::apply_mass(std::span<const double> x, std::span<double> y) const { add_mass(1.0, x, y); }

void PointsBody::add_mass(double factor, std::span<const double> x, std::span<double> y) const {
  for (std::size_t i = 0; i < mass_.size(); ++i) {
    three(y, 2 * i) += factor * mass_[i] * three(x, 2 * i);
    three(y, 2 * i + 1) += factor * inertia_[i] * three(x, 2 * i + 1);
  }
}

void PointsBody::add_rolling(double factor, std::span<const double> x, std::span<double> y) const {
  for (std::size_t i = 0; i < roll_.size(); ++i) three(y, 2 * i + 1) += factor * roll_[i] * three(x, 2 * i + 1);
}

void PointsBody::apply_stiffness(std::span<const double> x, std::span<double> y) const {
  pairs_.multiply_add(-1.0, 0.0, x, y);
}

void PointsBody::apply_damping(std::span<const double> x, std::span<double> y) const {
  add_mass(-options_.mass_damping, x, y);
  add_rolling(-1.0, x, y);
  pairs_.multiply_add(0.0, -1.0, x, y);
}

void PointsBody::apply_system(std::span<const double> x, std::span<double> y) const {
  add_mass(1.0 + dt_ * options_.mass_damping, x, y);
  add_rolling(dt_, x, y);
  pairs_.multiply_add(dt_ * dt_, dt_, x, y);
}

void PointsBody::add_system_diagonal(std::size_t first, BlockDiagonal& D) const {
  const double b = 1.0 + dt_ * options_.mass_damping;
  parallel_blocks(mass_.size(), 512, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      // What does not turn is infinitely heavy to the preconditioner, which does not filter.
      const double spin = turn_ ? b * inertia_[i] + dt_ * roll_[i] : kNoTurn * inertia_[i];
      GrainPairs::Mat6 block = pairs_.diagonal(i, dt_ * dt_, dt_);
      block.topLeftCorner<3, 3>() += b * mass_[i] * Mat3::Identity();
      block.bottomRightCorner<3, 3>() += spin * Mat3::Identity();
      D.block(first + i) += block;
    }
  });
}

SixCouplings PointsBody::couplings() const {
  SixCouplings c = pairs_.couplings();
  c.prescribed = given_;
  return c;
}

void PointsBody::filter_spin(std::span<double> x) const {
  for (std::size_t i = 0; i < mass_.size(); ++i) three(x, 2 * i + 1).setZero();
}

void PointsBody::filter(std::span<double> x) const {
  for (const std::int32_t i : prescribed_) std::fill_n(x.begin() + 6 * std::ptrdiff_t{i}, 6, 0.0);
  if (!turn_) filter_spin(x);
}

double PointsBody::relative_speed_bound(int p, std::span<const double> v) const {
  const Vec3 mean = mean_velocity(p, v);
  double largest = 0.0;
  for (std::size_t i = 0; i < mass_.size(); ++i) largest = std::max(largest, (three(v, 2 * i) - mean).squaredNorm());
  return std::sqrt(largest);
}

void PointsBody::motion_clusters(int, std::span<const double> v, std::vector<MotionCluster>& out) const {
  measure_cells(cells_, x_, v, largest_, out);
}

void PointsBody::finer_clusters(int, std::size_t cluster, std::span<const double> v,
                                std::vector<MotionCluster>& out) const {
  measure_cell(cells_, cluster, x_, v, largest_, out);
}

double PointsBody::kinetic_energy(std::span<const double> v) const {
  double e = 0.0;
  for (std::size_t i = 0; i < mass_.size(); ++i)
    e += 0.5 * (mass_[i] * three(v, 2 * i).squaredNorm() + inertia_[i] * three(v, 2 * i + 1).squaredNorm());
  return e;
}

Vec3 PointsBody::linear_momentum(std::span<const double> v) const {
  Vec3 p = Vec3::Zero();
  for (std::size_t i = 0; i < mass_.size(); ++i) p += mass_[i] * three(v, 2 * i);
  return p;
}

Vec3 PointsBody::angular_momentum(std::span<const double> v) const {
  Vec3 l = Vec3::Zero();
  for (std::size_t i = 0; i < mass_.size(); ++i)
    l += mass_[i] * x_[i].cross(three(v, 2 * i)) + inertia_[i] * three(v, 2 * i + 1);
  return l;
}

bool PointsBody::rigid_motion(const Vec3& t, const Vec3& w, std::span<double> v) const {
  for (std::size_t i = 0; i < mass_.size(); ++i)
    three(v, 2 * i) = t + w.cross(x_[i]), three(v, 2 * i + 1) = turn_ ? w : Vec3(Vec3::Zero());
  return true;
}

}  // namespace brim
