#include "brim/solve/projected_gauss_seidel.h"

#include <algorithm>
#include <cmath>

#include "brim/solve/contact_cone.h"

namespace brim {

namespace {

/// Rounds over the contacts of a rigid pair each time that a sweep comes to it.
constexpr int kRounds = 2;

}  // namespace

void ProjectedGaussSeidel::clear() {
  place_.clear(), group_.clear(), pairs_.clear();
  entries_.clear(), friction_.clear(), local_.clear(), local_inverse_.clear();
  first_.assign(1, 0);
}

void ProjectedGaussSeidel::add(std::span<const Entry> entries, double friction) {
  Mat3 W = Mat3::Zero();
  for (const Entry& e : entries) W += e.row * e.response.transpose();
  group_.push_back({size(), size() + 1, false, friction_.size()});
  place_.push_back({false, friction_.size()});
  entries_.insert(entries_.end(), entries.begin(), entries.end());
  first_.push_back(entries_.size());
  friction_.push_back(friction);
  local_.push_back(W);
  local_inverse_.push_back(invert_response(W));
}

void ProjectedGaussSeidel::add_pair(const RigidPairRows::Side& a, const RigidPairRows::Side& b,
                                    std::span<const Vec3> points, std::span<const Vec3> grips,
                                    std::span<const Mat3> frames, double friction) {
  group_.push_back({size(), size() + points.size(), true, pairs_.pairs()});
  for (std::size_t i = 0; i < points.size(); ++i) place_.push_back({true, pairs_.size() + i});
  pairs_.add(a, b, points, grips, frames, friction);
}

Vec3 ProjectedGaussSeidel::row_velocity(std::size_t r, std::span<const double> v) const {
  Vec3 u = Vec3::Zero();
  for (std::size_t i = first_[r]; i < first_[r + 1]; ++i) u += entries_[i].row * v[entries_[i].index];
  return u;
}

void ProjectedGaussSeidel::add_row_response(std::size_t r, const Vec3& impulse, std::span<double> v) const {
  for (std::size_t i = first_[r]; i < first_[r + 1]; ++i) v[entries_[i].index] += entries_[i].response.dot(impulse);
}

Vec3 ProjectedGaussSeidel::velocity(std::size_t c, std::span<const double> v) const {
  const Place& p = place_[c];
  return p.rigid ? pairs_.velocity(p.row, v) : row_velocity(p.row, v);
}

void ProjectedGaussSeidel::add_response(std::size_t c, const Vec3& impulse, std::span<double> v) const {
  const Place& p = place_[c];
  p.rigid ? pairs_.add_response(p.row, impulse, v) : add_row_response(p.row, impulse, v);
}

void ProjectedGaussSeidel::add_force(std::size_t c, const Vec3& impulse, std::span<double> Q) const {
  const Place& p = place_[c];
  if (p.rigid) return pairs_.add_force(p.row, impulse, Q);
  for (std::size_t i = first_[p.row]; i < first_[p.row + 1]; ++i)
    if (entries_[i].index < Q.size()) Q[entries_[i].index] += entries_[i].row.dot(impulse);
}

double ProjectedGaussSeidel::relax(std::size_t r, double friction, const Vec3& offset, double target, Vec3& impulse,
                                   std::span<double> v) const {
  const Mat3& W = local_[r];
  if (!(W(0, 0) > 0.0)) return 0.0;
  Vec3 u = row_velocity(r, v) + offset;
  u.x() -= target;
  const Vec3 next = relax_contact(W, local_inverse_[r], friction * friction_[r], u, impulse), change = next - impulse;
  impulse = next;
  add_row_response(r, change, v);
  return (W * change).cwiseAbs().maxCoeff();
}

double ProjectedGaussSeidel::sweep(bool backward, double friction, std::span<const Vec3> offset,
                                   std::span<const double> target, std::span<Vec3> impulse, std::span<double> v) const {
  double worst = 0.0;
  for (std::size_t k = 0; k < group_.size(); ++k) {
    const Group& g = group_[backward ? group_.size() - 1 - k : k];
    const std::size_t n = g.end - g.begin;
    const double change = g.rigid ? pairs_.relax(g.index, backward, kRounds, friction, offset.subspan(g.begin, n),
                                                 target.subspan(g.begin, n), impulse.subspan(g.begin, n), v)
                                  : relax(g.index, friction, offset[g.begin], target[g.begin], impulse[g.begin], v);
    worst = std::max(worst, change);
  }
  return worst;
}

void ProjectedGaussSeidel::solve_alone(std::size_t g, std::span<const Vec3> offset, std::span<const double> target,
                                       int rounds, std::span<Vec3> impulse, std::span<double> v) const {
  const Group& group = group_[g];
  const std::size_t n = group.end - group.begin;
  if (group.rigid)
    pairs_.relax(group.index, false, rounds, 0.0, offset.subspan(group.begin, n), target.subspan(group.begin, n),
                 impulse.subspan(group.begin, n), v);
  else
    relax(group.index, 0.0, offset[group.begin], target[group.begin], impulse[group.begin], v);
}

ProjectedGaussSeidel::Report ProjectedGaussSeidel::solve(std::span<const Vec3> offset, std::span<const double> target,
                                                         double tolerance, int max_sweeps, double scale,
                                                         std::span<Vec3> impulse, std::span<double> v,
                                                         double friction) {
  Report report;
  const std::size_t n = size();
  for (std::size_t c = 0; c < n; ++c) {
    const Vec3 u = velocity(c, v) + offset[c];
    if (u.x() < target[c] || impulse[c].x() > 0.0) scale = std::max(scale, std::abs(u.x() - target[c]));
  }
  if (n == 0 || !(scale > 0.0)) return report;
  report.converged = false;
  // A forward and a backward sweep are one step; between steps the last directions are followed further.
  way_.assign(n, Vec3::Zero());
  v_way_.assign(v.size(), 0.0);
  double last = 0.0;
  while (report.sweeps < max_sweeps) {
    before_.assign(impulse.begin(), impulse.end());
    v_before_.assign(v.begin(), v.end());
    double worst = sweep(false, friction, offset, target, impulse, v);
    worst = std::max(worst, sweep(true, friction, offset, target, impulse, v));
    report.sweeps += 2;
    report.residual = worst / scale;
    report.converged = report.residual <= tolerance;
    if (report.converged || report.sweeps >= max_sweeps) break;
    double size = 0.0;
    for (std::size_t c = 0; c < n; ++c) size += (impulse[c] - before_[c]).squaredNorm();
    const double beta = last > 0.0 ? size / last : 0.0;
    const bool further = beta > 0.0 && beta <= 1.0;
    last = size;
    for (std::size_t c = 0; c < n; ++c) {
      const Vec3 step = impulse[c] - before_[c];
      if (further) impulse[c] += beta * way_[c];
      way_[c] = further ? Vec3(beta * way_[c] + step) : step;
    }
    for (std::size_t i = 0; i < v.size(); ++i) {
      const double step = v[i] - v_before_[i];
      if (further) v[i] += beta * v_way_[i];
      v_way_[i] = further ? beta * v_way_[i] + step : step;
    }
  }
  return report;
}

}  // namespace brim
