#include "brim/body/articulated/tree_flow.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace brim {

double TreeFlow::kinetic_energy(const Tree& tree, std::span<const double> q, std::span<const double> v) {
  tree.place(q, pose_);
  std::fill(bias_.begin(), bias_.end(), 0.0);
  tree.add_mass(pose_, v, twist_, bias_);
  double e = 0.0;
  for (std::size_t i = 0; i < v.size(); ++i) e += 0.5 * v[i] * bias_[i];
  return e;
}

void TreeFlow::acceleration(const Tree& tree) {
  tree.place(stage_q_, pose_);
  inverse_.factor(tree, pose_, unloaded_);
  tree.twists(pose_, stage_v_, twist_);
  std::fill(bias_.begin(), bias_.end(), 0.0);
  tree.add_bias(pose_, stage_v_, twist_, scratch_, bias_);
  for (double& c : bias_) c = -c;
  inverse_.solve(bias_, scratch_, rate_v_);
}

void TreeFlow::piece(const Tree& tree, double dt) {
  static constexpr double kStage[] = {0.5, 0.5, 1.0}, kWeight[] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
  stage_q_ = q_, stage_v_ = v_;
  sum_q_ = q_, sum_v_ = v_;
  for (int s = 0; s < 4; ++s) {
    tree.rate(stage_q_, stage_v_, rate_q_);
    acceleration(tree);
    for (std::size_t i = 0; i < q_.size(); ++i) sum_q_[i] += dt * kWeight[s] * rate_q_[i];
    for (std::size_t i = 0; i < v_.size(); ++i) sum_v_[i] += dt * kWeight[s] * rate_v_[i];
    if (s == 3) break;
    for (std::size_t i = 0; i < q_.size(); ++i) stage_q_[i] = q_[i] + dt * kStage[s] * rate_q_[i];
    for (std::size_t i = 0; i < v_.size(); ++i) stage_v_[i] = v_[i] + dt * kStage[s] * rate_v_[i];
  }
  q_.swap(sum_q_), v_.swap(sum_v_);
  tree.move(0.0, v_, q_);  // quaternions back to length 1
}

double TreeFlow::stop(const Tree& tree, double dt, JointStops& stops) {
  if (stops.empty()) return 0.0;
  const std::vector<JointStop> ahead = stops.ahead(tree, dt, q_, v_);
  if (ahead.empty()) return 0.0;
  tree.place(q_, pose_);
  inverse_.factor(tree, pose_, unloaded_);
  return stops.hold(tree, pose_, inverse_, unloaded_, ahead, v_);
}

void TreeFlow::restore_momentum(const Tree& tree, const Vec6& wanted, const Vec3& point) {
  tree.place(q_, pose_);
  const Vec3 root = pose_.link[0].origin;
  Mat6 all = Mat6::Zero();  // the whole tree's inertia as if its joints were stiff, at the root
  for (std::size_t i = 0; i < tree.size(); ++i) {
    const TreePose::Link& p = pose_.link[i];
    all += moved_inertia(spatial_inertia(tree.links()[i].mass, p.center, p.inertia), p.origin - root);
  }
  const Eigen::LDLT<Mat6> factor(all);
  for (int pass = 0; pass < 2; ++pass) {  // the second takes away what rounding left
    tree.twists(pose_, v_, twist_);
    Vec6 missing = wanted - tree.momentum(pose_, twist_, point);
    missing.tail<3>() -= (root - point).cross(Vec3(missing.head<3>()));
    Eigen::Map<Vec6>(v_.data() + tree.links()[0].v0) += factor.solve(missing);
  }
}

Vec3 TreeFlow::center_of_mass(const Tree& tree) const { return tree.mass_center(pose_); }

void TreeFlow::shift(const Tree& tree, std::span<const double> way, std::span<double> q, std::span<double> v) {
  if (!tree.floating()) return tree.move(1.0, way, q);
  q_.assign(q.begin(), q.end()), v_.assign(v.begin(), v.end());
  twist_.resize(tree.size());
  tree.place(q_, pose_);
  tree.twists(pose_, v_, twist_);
  const Vec6 momentum = tree.momentum(pose_, twist_, center_of_mass(tree));
  tree.move(1.0, way, q_);
  tree.place(q_, pose_);
  restore_momentum(tree, momentum, center_of_mass(tree));
  std::copy(q_.begin(), q_.end(), q.begin());
  std::copy(v_.begin(), v_.end(), v.begin());
}

void TreeFlow::carry(const Tree& tree, std::span<const double> way, std::span<double> q, std::span<double> v) {
  bias_.resize(v.size()), twist_.resize(tree.size());
  const double energy = kinetic_energy(tree, q, v);
  std::vector<double> to(q.begin(), q.end()), moving(v.begin(), v.end()), together(v.size(), 0.0);
  shift(tree, way, to, moving);
  const double after = kinetic_energy(tree, to, moving);
  if (after > energy) {
    double least = 0.0;  // of the tree as one stiff body: of its momentum
    if (tree.floating()) {
      const Vec3 point = pose_.link[0].origin;
      tree.twists(pose_, moving, twist_);
      const Vec6 momentum = tree.momentum(pose_, twist_, point);
      q_ = to, v_ = together;
      restore_momentum(tree, momentum, point);
      together = v_;
      least = kinetic_energy(tree, to, together);
    }
    if (!(least <= energy && least < after)) return;
    const double scale = std::sqrt((energy - least) / (after - least));
    for (std::size_t i = 0; i < moving.size(); ++i) moving[i] = together[i] + scale * (moving[i] - together[i]);
  }
  std::copy(to.begin(), to.end(), q.begin());
  std::copy(moving.begin(), moving.end(), v.begin());
}

int TreeFlow::run(const Tree& tree, double dt, std::span<double> q, std::span<double> v, JointStops& stops) {
  const std::size_t nq = tree.q_size(), nv = tree.v_size();
  for (auto* x : {&q_, &stage_q_, &rate_q_, &sum_q_}) x->resize(nq);
  for (auto* x : {&v_, &stage_v_, &rate_v_, &sum_v_, &bias_}) x->resize(nv);
  twist_.resize(tree.size()), scratch_.resize(tree.size());
  unloaded_.assign(tree.size(), Mat3::Zero());

  const double energy = kinetic_energy(tree, q, v);
  if (!(energy > 0.0) || !std::isfinite(energy)) {
    tree.move(dt, v, q);
    return 0;
  }
  Vec6 momentum = Vec6::Zero();
  Vec3 point = Vec3::Zero();
  if (tree.floating()) {
    point = pose_.link[0].origin;
    tree.twists(pose_, v, twist_);
    momentum = tree.momentum(pose_, twist_, point);
  }
  int pieces = 1;
  double after = energy, taken = 0.0;
  for (;; pieces *= 2) {
    q_.assign(q.begin(), q.end()), v_.assign(v.begin(), v.end());
    taken = 0.0;
    for (int p = 0; p < pieces; ++p) {
      taken += stop(tree, dt / pieces, stops);
      piece(tree, dt / pieces);
    }
    after = kinetic_energy(tree, q_, v_);
    if (std::abs(after + taken - energy) <= kEnergyTolerance * energy || 2 * pieces > kMaxPieces) break;
  }
  if (!std::isfinite(after)) {  // hopelessly fast: along straight coordinates
    q_.assign(q.begin(), q.end()), v_.assign(v.begin(), v.end());
    tree.move(dt, v_, q_);
    after = kinetic_energy(tree, q_, v_), taken = 0.0;
  }
  if (tree.floating()) {
    restore_momentum(tree, momentum, point);
    after = kinetic_energy(tree, q_, v_);
  }
  const double left = std::max(energy - taken, 0.0);
  if (!(after <= left + 2.0 * kEnergyTolerance * energy)) {  // too fast for the pieces: slower, never faster
    const double scale = std::sqrt(left / after);
    for (double& x : v_) x *= scale;
  }
  std::copy(q_.begin(), q_.end(), q.begin());
  std::copy(v_.begin(), v_.end(), v.begin());
  return pieces;
}

}  // namespace brim
