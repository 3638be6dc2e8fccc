// How an own body moves: its mass points turn with their mean motion, as those of the built-in deformable kinds do
// (docs/numerics.md, Momentum of deformable bodies), and the coordinates follow them by least squares.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "brim/body/own/own_body.h"
#include "brim/body/particles/mean_motion.h"

namespace brim {

namespace {

using Vector = Eigen::VectorXd;

/// [-] of a rigid motion that coordinates cannot follow.
constexpr double kCannotFollow = 1e-6;
/// [rad] by which a body is turned to see whether its energy minds, and of what stretching it so far would take the
/// share that is rounding and differences.
constexpr double kTurn = 1e-2, kMinds = 1e-3;
/// Corrections of the nearest coordinates, and the last one's size as a share of the extent: rounding, and what is too
/// far. Each reduces the error by some (ω dt)²/2, and by all of it where deform is linear.
constexpr int kCorrections = 30;
constexpr double kReached = 1e-13, kMissed = 1e-8;

Eigen::Map<const Vector> column_of(std::span<const double> x) {
  return {x.data(), static_cast<Eigen::Index>(x.size())};
}
Eigen::Map<Vector> writable_column(std::span<double> x) { return {x.data(), static_cast<Eigen::Index>(x.size())}; }

/// The points of a flat array of triples.
std::span<const Vec3> points(std::span<const double> x) {
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  return {reinterpret_cast<const Vec3*>(x.data()), x.size() / 3};
}
std::span<Vec3> points(std::span<double> x) { return {reinterpret_cast<Vec3*>(x.data()), x.size() / 3}; }

}  // namespace

std::vector<double> OwnBody::piece_places(Coordinates q) const {
  std::vector<double> x(3 * piece_.size());
  ask_deform(q, piece_, points(std::span(x)));
  return x;
}

std::vector<double> OwnBody::piece_velocities(std::span<const double> v) const {
  std::vector<double> u(3 * piece_.size());
  J_.apply(v, points(std::span(u)));
  return u;
}

Eigen::VectorXd OwnBody::gather(const DenseMap& J, std::span<const double> u) const {
  Vector sum = Vector::Zero(static_cast<Eigen::Index>(q_.size()));
  for (std::size_t k = 0; k < piece_.size(); ++k)
    sum.noalias() += J.row(k).transpose().lazyProduct(Vec3(piece_mass_[k] * points(u)[k]));
  return sum;
}

Eigen::MatrixXd OwnBody::mass_matrix(const DenseMap& J) const {
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(M_.rows(), M_.cols());
  for (std::size_t k = 0; k < piece_.size(); ++k)
    M.noalias() += (piece_mass_[k] * J.row(k).transpose()).lazyProduct(J.row(k));
  return M;
}

bool OwnBody::follows_rigid_motion() const {
  const Eigen::LDLT<Eigen::MatrixXd> inverse(M_);
  // Mass and inertia by the coordinates, and by the pieces.
  const Mat3 mass = linear_ * inverse.solve(linear_.transpose()), all = mass_ * Mat3::Identity();
  if (!((mass - all).norm() <= kCannotFollow * mass_)) return false;
  const Vec3 center = first_moment_ / mass_;
  Mat3 inertia = Mat3::Zero();
  for (std::size_t k = 0; k < piece_.size(); ++k) {
    const Vec3 d = points(std::span(x_))[k] - center;
    inertia += piece_mass_[k] * (d.squaredNorm() * Mat3::Identity() - d * d.transpose());
  }
  const Jacobian spin = angular_ - skew(center) * linear_;
  const Mat3 followed = spin * inverse.solve(spin.transpose());
  return (followed - inertia).norm() <= kCannotFollow * inertia.norm();
}

bool OwnBody::is_energy_turned() const {
  const Vec3 center = first_moment_ / mass_;
  const double start = energy(q_);
  for (int axis = 0; axis < 3; ++axis) {
    const Mat3 R = Eigen::AngleAxisd(kTurn, Vec3::Unit(axis)).toRotationMatrix();
    std::vector<double> turned = x_, q = q_;
    for (Vec3& x : points(std::span(turned))) x = center + R * (x - center);
    if (!fit(turned, q)) return false;
    const Vector way = column_of(q) - column_of(q_);
    const double stretched = 0.5 * K_.norm() * way.squaredNorm();
    if (!(std::abs(energy(q) - start) <= kMinds * stretched)) return false;
  }
  return true;
}

bool OwnBody::fit(std::span<const double> x, std::span<double> q) const {
  const Eigen::LDLT<Eigen::MatrixXd> inverse(M_);
  std::vector<double> nearest(q.begin(), q.end());
  double size = 0.0;
  for (std::size_t k = 0; k < piece_.size(); ++k) size = std::max(size, points(x)[k].cwiseAbs().maxCoeff());
  double last = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kCorrections; ++i) {
    std::vector<double> miss = piece_places(nearest);
    writable_column(miss) = column_of(x) - column_of(miss);
    const Vector to = gather(J_, miss), step = inverse.solve(to);
    const double way = std::sqrt(std::max(0.0, step.dot(to)) / mass_);
    if (!std::isfinite(way)) return false;
    // Rounding does not get less.
    if (way >= last && last <= kMissed * size) break;
    if (way >= last) return false;
    writable_column(nearest) += step;
    last = way;
    if (way <= kReached * size) break;
  }
  if (!(last <= kMissed * size)) return false;
  std::copy(nearest.begin(), nearest.end(), q.begin());
  return true;
}

void OwnBody::advance(double dt, std::span<double> q, std::span<const double> v) const {
  const std::vector<double> start(q.begin(), q.end());
  writable_column(q) += dt * column_of(v);
  if (!rigid_) return;
  std::vector<double> x = start == q_ ? x_ : piece_places(start);
  advance_turning(pieces(), dt, x, piece_velocities(v));
  fit(x, q);
}

void OwnBody::add_forces_of_motion(std::span<double> Q) const {
  if (!rigid_) {
    writable_column(Q) -= bias_;
    return;
  }
  std::vector<double> f(x_.size(), 0.0);
  add_turning_forces(pieces(), dt_, x_, piece_velocities(v_), f);
  J_.apply_transpose(points(std::span<const double>(f)), Q);
}

void OwnBody::finish_step(double, double dt, std::span<double> q, std::span<double> v) {
  if (!rigid_) return;
  // Elastic forces have no torque about the middle: what the solve's linear change of them had is given back.
  std::vector<double> given(x_.size(), 0.0);
  if (turns_freely_) {
    const Eigen::LDLT<Eigen::MatrixXd> inverse(M_);
    const Vector impulse = dt * force_ + dt * (dt + model_.stiffness_damping) * (K_ * column_of(v));
    const Vector change = inverse.solve(impulse);
    given = piece_velocities({change.data(), static_cast<std::size_t>(change.size())});
    const Vec3 mean = linear_ * change / mass_;
    for (std::size_t k = 0; k < piece_.size(); ++k) {
      Vec3& j = points(std::span(given))[k];
      j = -piece_mass_[k] * (j - mean);
    }
  }
  std::vector<double> u = piece_velocities(v);
  next_q_.assign(q.begin(), q.end());
  next_x_ = piece_places(next_q_);
  // Its correction of the places, here of rounding's size, is not in q: update() must find the same places anew.
  std::vector<double> after = next_x_;
  turn_velocities(pieces(), dt, x_, after, u, given);
  next_J_.reset(piece_.size(), q.size());
  ask_jacobian(next_q_, piece_, next_J_);
  writable_column(v) = mass_matrix(next_J_).ldlt().solve(gather(next_J_, u));
}

void OwnBody::turns(std::span<const double> v, std::span<Turn> part) const {
  Turn all;
  if (rigid_) {
    const MeanMotion m = mean_motion(pieces(), x_, piece_velocities(v));
    all = {.center = m.center, .spin = m.spin};
  }
  std::ranges::fill(part, all);
}

}  // namespace brim
