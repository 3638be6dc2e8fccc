#include "brim/solve/conjugate_gradient.h"

#include <algorithm>
#include <cmath>

#include "brim/core/parallel.h"
#include "brim/core/simd.h"

namespace brim {

namespace {

/// In lanes, whose order of adding does not depend on the machine.
double dot(std::span<const double> a, std::span<const double> b) {
  return ordered_sum(a.size(), [&](std::size_t begin, std::size_t end) {
    constexpr std::size_t kStep = 4 * kLanes;
    Lanes sum[4] = {};
    std::size_t i = begin;
    for (; i + kStep <= end; i += kStep)
      for (std::size_t k = 0; k < 4; ++k)
        sum[k] += load_lanes(a.data() + i + k * kLanes) * load_lanes(b.data() + i + k * kLanes);
    const Lanes all = (sum[0] + sum[1]) + (sum[2] + sum[3]);
    double s = (all[0] + all[1]) + (all[2] + all[3]);
    for (; i < end; ++i) s += a[i] * b[i];
    return s;
  });
}

}  // namespace

SolveReport ConjugateGradient::solve(const LinearSystem& system, std::span<const double> b, double tolerance,
                                     int max_iterations, std::span<double> x, double scale) {
  const std::size_t n = b.size();
  r_.resize(n), z_.resize(n), p_.resize(n), y_.resize(n);
  SolveReport report;

  system.filter(x);
  const bool warm = std::any_of(x.begin(), x.end(), [](double xi) { return xi != 0.0; });
  if (!warm || scale == 0.0) {
    std::copy(b.begin(), b.end(), r_.begin());
    system.filter(r_);
    system.precondition(r_, z_);
    scale = dot(r_, z_);
  }
  report.scale = scale;
  report.finite = std::isfinite(scale);
  if (!report.finite) return report;
  if (scale <= 0.0) {
    std::fill(x.begin(), x.end(), 0.0);
    report.converged = true;
    return report;
  }

  // r = S (b − A x)
  if (warm) {
    system.apply(x, y_);
    for (std::size_t i = 0; i < n; ++i) r_[i] = b[i] - y_[i];
    system.filter(r_);
    system.precondition(r_, z_);
  }
  system.filter(z_);
  std::copy(z_.begin(), z_.end(), p_.begin());
  double rz = warm ? dot(r_, z_) : scale;
  const double goal = std::max(tolerance * tolerance * scale, system.negligible);
  while (rz > goal && report.iterations < max_iterations) {
    system.apply(p_, y_);
    system.filter(y_);
    const double curvature = dot(p_, y_);
    if (!std::isfinite(curvature)) {
      report.finite = false;
      return report;
    }
    if (!(curvature > 0.0)) break;
    const double step = rz / curvature;
    parallel_blocks(n, 16384, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        x[i] += step * p_[i];
        r_[i] -= step * y_[i];
      }
    });
    system.precondition(r_, z_);
    system.filter(z_);
    const double next = dot(r_, z_);
    const double ratio = next / rz;
    rz = next;
    parallel_blocks(n, 16384, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) p_[i] = z_[i] + ratio * p_[i];
    });
    ++report.iterations;
    if (!std::isfinite(rz)) {
      report.finite = false;
      return report;
    }
  }
  report.residual = std::sqrt(std::max(0.0, rz) / scale);
  report.converged = rz <= goal;
  return report;
}

}  // namespace brim
