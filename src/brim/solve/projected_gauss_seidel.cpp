#include "brim/solve/projected_gauss_seidel.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace brim {

void ProjectedGaussSeidel::clear() {
  entries_.clear(), friction_.clear(), local_.clear(), local_inverse_.clear();
  first_.assign(1, 0);
}

void ProjectedGaussSeidel::add(std::span<const Entry> entries, double friction) {
  Mat3 W = Mat3::Zero();
  for (const Entry& e : entries) W += e.row * e.response.transpose();
  entries_.insert(entries_.end(), entries.begin(), entries.end());
  first_.push_back(entries_.size());
  friction_.push_back(friction);
  local_.push_back(W);
  const double scale = W.trace() / 3.0;
  const bool regular = scale > 0.0 && W.determinant() > 1e-9 * scale * scale * scale;
  local_inverse_.push_back(regular ? Mat3(W.inverse()) : Mat3::Zero());
}

Vec3 ProjectedGaussSeidel::velocity(std::size_t c, std::span<const double> v) const {
  Vec3 u = Vec3::Zero();
  for (std::size_t i = first_[c]; i < first_[c + 1]; ++i) u += entries_[i].row * v[entries_[i].index];
  return u;
}

void ProjectedGaussSeidel::add_response(std::size_t c, const Vec3& impulse, std::span<double> v) const {
  for (std::size_t i = first_[c]; i < first_[c + 1]; ++i) v[entries_[i].index] += entries_[i].response.dot(impulse);
}

void ProjectedGaussSeidel::add_force(std::size_t c, const Vec3& impulse, std::span<double> Q) const {
  for (std::size_t i = first_[c]; i < first_[c + 1]; ++i)
    if (entries_[i].index < Q.size()) Q[entries_[i].index] += entries_[i].row.dot(impulse);
}

double ProjectedGaussSeidel::relax(std::size_t c, const Vec3& offset, double target, Vec3& impulse,
                                   std::span<double> v) const {
  const Mat3& W = local_[c];
  if (!(W(0, 0) > 0.0)) return 0.0;
  Vec3 u = velocity(c, v) + offset;
  u.x() -= target;

  // All three at once where the contact then sticks; otherwise the normal, then the tangents projected to the disc.
  const bool regular = local_inverse_[c](0, 0) > 0.0;
  Vec3 next = regular ? Vec3(impulse - local_inverse_[c] * u) : Vec3(-1.0, 0.0, 0.0);
  if (next.x() < 0.0 || next.tail<2>().norm() > friction_[c] * next.x()) {
    next = impulse;
    next.x() = std::max(0.0, impulse.x() - u.x() / W(0, 0));
    const double most = friction_[c] * next.x();
    const double stiff = W.bottomRightCorner<2, 2>().trace();
    if (most > 0.0 && stiff > 0.0) {
      const Eigen::Vector2d slip = u.tail<2>() + W.block<2, 1>(1, 0) * (next.x() - impulse.x());
      next.tail<2>() -= slip / stiff;
    } else {
      next.tail<2>().setZero();
    }
    const double length = next.tail<2>().norm();
    if (length > most) next.tail<2>() *= most / length;
  }
  const Vec3 change = next - impulse;
  impulse = next;
  add_response(c, change, v);
  return (W * change).cwiseAbs().maxCoeff();
}

ProjectedGaussSeidel::Report ProjectedGaussSeidel::solve(std::span<const Vec3> offset, std::span<const double> target,
                                                         double tolerance, int max_sweeps, double scale,
                                                         std::span<Vec3> impulse, std::span<double> v) const {
  Report report;
  const std::size_t n = size();
  for (std::size_t c = 0; c < n; ++c) {
    const Vec3 u = velocity(c, v) + offset[c];
    if (u.x() < target[c] || impulse[c].x() > 0.0) scale = std::max(scale, std::abs(u.x() - target[c]));
  }
  if (n == 0 || !(scale > 0.0)) return report;
  report.converged = false;
  // A forward and a backward sweep are one step; between steps the last directions are followed further.
  std::vector<Vec3> before, way(n, Vec3::Zero());
  std::vector<double> v_before, v_way(v.size(), 0.0);
  double last = 0.0;
  while (report.sweeps < max_sweeps) {
    before.assign(impulse.begin(), impulse.end());
    v_before.assign(v.begin(), v.end());
    double worst = 0.0;
    for (std::size_t i = 0; i < n; ++i) worst = std::max(worst, relax(i, offset[i], target[i], impulse[i], v));
    for (std::size_t i = n; i-- > 0;) worst = std::max(worst, relax(i, offset[i], target[i], impulse[i], v));
    report.sweeps += 2;
    report.residual = worst / scale;
    report.converged = report.residual <= tolerance;
    if (report.converged || report.sweeps >= max_sweeps) break;
    double size = 0.0;
    for (std::size_t c = 0; c < n; ++c) size += (impulse[c] - before[c]).squaredNorm();
    const double beta = last > 0.0 ? size / last : 0.0;
    const bool further = beta > 0.0 && beta <= 1.0;
    last = size;
    for (std::size_t c = 0; c < n; ++c) {
      const Vec3 step = impulse[c] - before[c];
      if (further) impulse[c] += beta * way[c];
      way[c] = further ? Vec3(beta * way[c] + step) : step;
    }
    for (std::size_t i = 0; i < v.size(); ++i) {
      const double step = v[i] - v_before[i];
      if (further) v[i] += beta * v_way[i];
      v_way[i] = further ? beta * v_way[i] + step : step;
    }
  }
  return report;
}

}  // namespace brim
