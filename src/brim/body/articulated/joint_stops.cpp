#include "brim/body/articulated/joint_stops.h"

#include <algorithm>
#include <cmath>

namespace brim {

namespace {

/// Inertia of a held joint's stop over the joint's own, in the inverse that finds its impulse. A pass leaves as much
/// less of the motion, and loses as much of rounding's sixteen digits.
constexpr double kHeldJoint = 1e4;
/// Rounds in which a stop that was left may hold again; after them stops are only left, so that they end.
constexpr int kStopRounds = 4;
/// Angle from rest below which a ball joint has no direction, [rad].
constexpr double kNoDirection = 1e-9;

}  // namespace

JointStops::JointStops(const ArticulatedModel& model) : hard_(model.links.size(), 0) {
  for (std::size_t i = 0; i < model.links.size(); ++i) {
    const JointModel& j = model.links[i].joint;
    if (j.kind == JointKind::Fixed || j.kind == JointKind::Free) continue;
    if (std::isfinite(j.upper) || std::isfinite(j.lower)) limited_.push_back({i, j.lower, j.upper, j.limit_stiffness});
  }
}

void JointStops::choose(double dt, const TreeInverse& mass) {
  for (const Limits& l : limited_) hard_[l.link] = !(l.stiffness > 0.0) || l.stiffness * dt * dt >= mass.pivot(l.link);
}

std::vector<JointStop> JointStops::ahead(const Tree& tree, double dt, std::span<const double> q,
                                         std::span<const double> v) const {
  std::vector<JointStop> out;
  const auto meet = [&](std::size_t link, double gap, double rate, const Vec3& outwards) {
    if (rate > 0.0 && dt * rate > gap) out.push_back({link, outwards, std::max(gap, 0.0) / dt});
  };
  for (const Limits& l : limited_) {
    if (!hard_[l.link]) continue;
    const Tree::Link& link = tree.links()[l.link];
    const double* u = v.data() + link.v0;
    const Vec3 x = joint_displacement(link.dof, q.data() + link.q0);
    if (link.dof == 1) {
      meet(l.link, l.upper - x[0], u[0], Vec3(1, 0, 0));
      meet(l.link, x[0] - l.lower, -u[0], Vec3(-1, 0, 0));
    } else if (const double angle = x.norm(); angle > kNoDirection) {
      meet(l.link, l.upper - angle, x.dot(Vec3(u[0], u[1], u[2])) / angle, x / angle);
    }
  }
  return out;
}

std::vector<double> JointStops::excess(const Tree& tree, std::span<const double> q) const {
  std::vector<double> out;
  for (const Limits& l : limited_) {
    const Tree::Link& link = tree.links()[l.link];
    const Vec3 x = joint_displacement(link.dof, q.data() + link.q0);
    out.push_back(link.dof == 1 ? std::max(x[0] - l.upper, l.lower - x[0]) : x.norm() - l.upper);
  }
  return out;
}

void JointStops::rates(const Tree& tree, std::span<const JointStop> stops, std::span<const double> v,
                       std::span<double> rate) const {
  for (std::size_t s = 0; s < stops.size(); ++s) {
    const Tree::Link& l = tree.links()[stops[s].link];
    rate[s] = 0.0;
    for (int k = 0; k < l.dof; ++k) rate[s] += stops[s].outwards[k] * v[l.v0 + k];
  }
}

void JointStops::push(const Tree& tree, const TreeInverse& inverse, std::span<const JointStop> stops,
                      std::span<const double> impulse, std::span<double> v) {
  load_.assign(v.size(), 0.0), change_.resize(v.size()), scratch_.resize(tree.size());
  for (std::size_t s = 0; s < stops.size(); ++s) {
    const Tree::Link& l = tree.links()[stops[s].link];
    for (int k = 0; k < l.dof; ++k) load_[l.v0 + k] += impulse[s] * stops[s].outwards[k];
  }
  inverse.solve(load_, scratch_, change_);
  for (std::size_t i = 0; i < v.size(); ++i) v[i] += change_[i];
}

void JointStops::find_impulses(const Tree& tree, std::span<const JointStop> stops, std::span<const double> rate,
                               std::span<const double> v, std::span<double> impulse) {
  std::vector<double> trial(v.begin(), v.end());
  const auto pull = [&](std::span<const double> at) {
    for (std::size_t s = 0; s < stops.size(); ++s)
      impulse[s] = holds_[s] != 0 ? -weight_[s] * (at[s] - stops[s].most) : 0.0;
  };
  pull(rate);
  push(tree, held_, stops, impulse, trial);
  trial_rate_.resize(stops.size());
  rates(tree, stops, trial, trial_rate_);
  pull(trial_rate_);
}

bool JointStops::factor_held(const Tree& tree, const TreePose& pose, std::span<const Mat3> T,
                             std::span<const JointStop> stops) {
  terms_.assign(T.begin(), T.end());
  for (std::size_t s = 0; s < stops.size(); ++s) {
    const Vec3& n = stops[s].outwards;
    if (holds_[s] != 0) terms_[stops[s].link] += weight_[s] * n * n.transpose();
  }
  return held_.factor(tree, pose, terms_);
}

double JointStops::hold(const Tree& tree, const TreePose& pose, const TreeInverse& inverse, std::span<const Mat3> T,
                        std::span<const JointStop> stops, std::span<double> v) {
  const std::size_t n = stops.size();
  std::vector<double> total(n), more(n), free_rate(n), rate(n);
  weight_.resize(n), holds_.resize(n);
  for (std::size_t s = 0; s < n; ++s) {
    const JointStop& stop = stops[s];
    weight_[s] = kHeldJoint * (inverse.pivot(stop.link) + stop.outwards.dot(T[stop.link] * stop.outwards));
    total[s] = -stop.impulse;
  }
  push(tree, inverse, stops, total, v);
  rates(tree, stops, v, free_rate);
  const auto passes = [&](std::size_t s, double u) { return stops[s].pulls ? u < stops[s].most : u > stops[s].most; };
  for (std::size_t s = 0; s < n; ++s) holds_[s] = stops[s].impulse != 0.0 || passes(s, free_rate[s]);
  bool changed = true;
  for (int round = 0; changed; ++round) {
    if (std::count(holds_.begin(), holds_.end(), 0) == static_cast<std::ptrdiff_t>(n)) return 0.0;
    if (!factor_held(tree, pose, T, stops)) return 0.0;
    find_impulses(tree, stops, free_rate, v, total);
    changed = false;
    for (std::size_t s = 0; s < n; ++s) {
      const bool right = stops[s].pulls ? total[s] > 0.0 : total[s] < 0.0;
      const bool holds = holds_[s] != 0 ? right : round < kStopRounds && passes(s, trial_rate_[s]);
      changed = changed || holds != (holds_[s] != 0);
      holds_[s] = holds;
    }
  }
  push(tree, inverse, stops, total, v);
  rates(tree, stops, v, rate);
  find_impulses(tree, stops, rate, v, more);  // what the first pass left
  push(tree, inverse, stops, more, v);
  rates(tree, stops, v, rate);
  double taken = 0.0;
  for (std::size_t s = 0; s < n; ++s) taken -= 0.5 * (total[s] + more[s]) * (free_rate[s] + rate[s]);
  return taken;
}

}  // namespace brim
