#include "brim/body/particles/strain_damped_body.h"

#include <algorithm>
#include <utility>

#include "brim/body/particles/mean_motion.h"
#include "brim/core/parallel.h"
#include "brim/solve/conjugate_gradient.h"

namespace brim {

namespace {

/// Energy of springs stretched by turning, relative to that of the motion, that is left to the next step.
constexpr double kLeft = 1e-4;
/// Number of corrections; relative accuracy of each, which the next improves; its most iterations.
constexpr int kRounds = 3;
constexpr double kAccuracy = 1e-2;
constexpr int kIterations = 200;
/// Share of the energy that a correction may leave at most to be kept.
constexpr double kWorth = 0.5;
/// Size of all corrections relative to the motion, by mass, up to which they are of second order.
constexpr double kSmall = 0.3;

}  // namespace

void StrainDampedBody::share_pattern(BlockMatrix pattern) {
  stiffness_ = pattern;
  damper_ = pattern;
  system_ = std::move(pattern);
}

void StrainDampedBody::begin_inner() {
  ParticleBody::begin_inner();
  damper_.set_zero();
}

void StrainDampedBody::end_inner() {
  ParticleBody::end_inner();
  damper_.close();
}

void StrainDampedBody::add_forces(const Environment& env, std::span<double> Q) const {
  const double a = options_.mass_damping;
  const std::span<const double> v(v_.data()->data(), 3 * v_.size());
  for (std::size_t i = 0; i < rest_.size(); ++i)
    Eigen::Map<Vec3>(Q.data() + 3 * i) += mass_[i] * env.gravity + force_[i] - a * mass_[i] * v_[i];
  if (options_.stiffness_damping > 0.0) damper_.multiply_add(-options_.stiffness_damping, 0.0, mass_, v, Q);
  add_turning_forces(particle_set(), dt_, {x_.data()->data(), 3 * x_.size()}, v, Q);
  add_outer_forces(Q);
}

void StrainDampedBody::apply_damping(std::span<const double> x, std::span<double> y) const {
  damper_.multiply_add(-options_.stiffness_damping, -options_.mass_damping, mass_, x, y);
}

void StrainDampedBody::add_turning_stiffness(std::span<const double> x, std::span<const std::uint8_t> guided,
                                             std::span<double> y) const {
  const auto at = [&](std::size_t i) { return Eigen::Map<const Vec3>(x.data() + 3 * i); };
  for (std::size_t i = 0; i < rest_.size(); ++i) {
    if (!guided[i]) continue;
    Vec3 sum = Vec3::Zero();
    for (std::int32_t s = stiffness_.row_first()[i]; s < stiffness_.row_first()[i + 1]; ++s) {
      const auto j = static_cast<std::size_t>(stiffness_.columns()[s]);
      if (j != i && guided[j]) sum += (stiffness_.block(s) - damper_.block(s)) * (at(j) - at(i));
    }
    Eigen::Map<Vec3>(y.data() + 3 * i) += sum;
  }
}

void StrainDampedBody::begin_solve(double dt) {
  ParticleBody::begin_solve(dt);
  system_.combine(dt * dt, stiffness_, dt * options_.stiffness_damping, damper_);
}

void StrainDampedBody::apply_system(std::span<const double> x, std::span<double> y) const {
  system_.multiply_add(1.0, 1.0 + dt_ * options_.mass_damping, mass_, x, y);
}

std::optional<BlockSystem> StrainDampedBody::block_system() const {
  BlockSystem system = *ParticleBody::block_system();
  system.stiffness = &system_, system.stiffness_share = 1.0;
  return system;
}

void StrainDampedBody::add_system_diagonal(std::size_t first, BlockDiagonal& D) const {
  const double b = 1.0 + dt_ * options_.mass_damping;
  parallel_blocks(rest_.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      D.block(first + i) += system_.diagonal(i) + b * mass_[i] * Mat3::Identity();
  });
}

Straighten StrainDampedBody::straightening(double dt) const {
  // The system of another step would not do. What hangs from prescribed particles converges to its rest without.
  if (stiff_springs() == nullptr || dt != dt_ || !prescribed_.empty()) return {};
  return [this](std::span<const double> x, std::span<const double> way, std::span<double> more) {
    return straighten(x, way, more);
  };
}

bool StrainDampedBody::straighten(std::span<const double> x, std::span<const double> way,
                                  std::span<double> more) const {
  const auto motion_of = [&](std::span<const double> moved) {
    double energy = 0.0;
    for (std::size_t i = 0; i < mass_.size(); ++i)
      energy += 0.5 * mass_[i] * Eigen::Map<const Vec3>(moved.data() + 3 * i).squaredNorm() / (dt_ * dt_);
    return energy;
  };
  const double motion = motion_of(way);
  std::vector<double> force(x.size(), 0.0), p(x.size());
  double energy = stiff_springs()->add_turned(x, way, more, force);
  if (!(energy > kLeft * motion)) return false;
  BlockDiagonal D;
  D.reset(block_sizes());
  add_system_diagonal(0, D);
  D.factor();
  LinearSystem system;
  system.apply = [&](std::span<const double> a, std::span<double> b) {
    std::fill(b.begin(), b.end(), 0.0);
    apply_system(a, b);
  };
  system.precondition = [&](std::span<const double> r, std::span<double> z) { D.solve(r, z); };
  // Links would pull back what is moved at them.
  system.filter = [&](std::span<double> a) {
    filter(a);
    for (std::size_t i = 0; i < linked_.size(); ++i)
      if (linked_[i] != 0) Eigen::Map<Vec3>(a.data() + 3 * i).setZero();
  };
  ConjugateGradient cg;
  for (int round = 0; round < kRounds && energy > kLeft * motion; ++round) {
    for (double& f : force) f *= dt_ * dt_;
    std::fill(p.begin(), p.end(), 0.0);
    if (!cg.solve(system, force, kAccuracy, kIterations, p).finite) return false;
    for (std::size_t i = 0; i < more.size(); ++i) more[i] += p[i];
    std::fill(force.begin(), force.end(), 0.0);
    const double before = std::exchange(energy, stiff_springs()->add_turned(x, way, more, force));
    if (energy < kWorth * before && motion_of(more) < kSmall * kSmall * motion) continue;
    // Far from where the springs are linear, corrections may make things worse.
    for (std::size_t i = 0; i < more.size(); ++i) more[i] -= p[i];
    if (round == 0) return false;
    break;
  }
  if (!linked_.empty()) return true;
  // The centre of mass stays, whatever the accuracy.
  Vec3 mean = Vec3::Zero();
  for (std::size_t i = 0; i < mass_.size(); ++i)
    mean += mass_[i] / mass() * Eigen::Map<const Vec3>(more.data() + 3 * i);
  for (std::size_t i = 0; i < mass_.size(); ++i) Eigen::Map<Vec3>(more.data() + 3 * i) -= mean;
  return true;
}

}  // namespace brim
