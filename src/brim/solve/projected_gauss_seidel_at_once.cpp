// All contacts of ProjectedGaussSeidel at once, where sweeps do not converge.
#include <algorithm>

#include "brim/solve/contact_admm.h"
#include "brim/solve/contact_cone.h"
#include "brim/solve/projected_gauss_seidel.h"

namespace brim {

namespace {

/// Iterations at most, the share of the tolerance at which they end, and sweeps after them.
constexpr int kIterations = 1000, kLastSweeps = 2;
constexpr double kAtOnceTolerance = 0.3;

}  // namespace

void ProjectedGaussSeidel::solve_at_once(std::span<const Vec3> offset, std::span<const double> target,
                                         SweepOptions options, std::span<Vec3> impulse, std::span<double> v,
                                         Report& report) {
  const std::size_t n = size();
  const std::vector<Vec3> swept(impulse.begin(), impulse.end());
  const std::vector<double> v_swept(v.begin(), v.end());
  std::vector<double> without(v.begin(), v.end()), mu(n);
  std::vector<Vec3> q(n);
  for (std::size_t c = 0; c < n; ++c) add_response(c, -impulse[c], without);
  for (std::size_t c = 0; c < n; ++c) {
    q[c] = velocity(c, without) + offset[c];
    q[c].x() -= target[c];
    mu[c] = options.friction * (place_[c].rigid ? pairs_.friction(place_[c].row) : friction_[place_[c].row]);
  }
  const Eigen::MatrixXd W = responses(v.size());
  const double near = kAtOnceTolerance * options.tolerance * options.scale;
  report.sweeps += ContactAdmm::solve(W, q, mu, near, kIterations, impulse).iterations;
  for (std::size_t c = 0; c < n; ++c) add_response(c, impulse[c] - swept[c], v);
  double worst = 0.0;
  for (std::size_t c = 0; c < n; ++c) {
    const auto at = static_cast<Eigen::Index>(3 * c);
    if (!(W(at, at) > 0.0)) continue;
    Vec3 u = velocity(c, v) + offset[c];
    u.x() -= target[c];
    worst = std::max(worst, contact_residual(W.block<3, 3>(at, at).trace() / 3.0, mu[c], u, impulse[c]));
  }
  const double at_once = worst / options.scale;
  // A contact may have several solutions, one that parts and one that jams, and sweeps may leave the one at hand for
  // the other. Where they stay they are right; where they do not, what was found for all at once is.
  const std::vector<Vec3> found(impulse.begin(), impulse.end());
  const std::vector<double> v_found(v.begin(), v.end());
  const auto take = [&](const std::vector<Vec3>& lambda, const std::vector<double>& velocities) {
    std::copy(lambda.begin(), lambda.end(), impulse.begin());
    std::copy(velocities.begin(), velocities.end(), v.begin());
  };
  const bool found_all = at_once <= options.tolerance;
  if (!found_all && !(at_once < report.residual)) take(swept, v_swept);
  options.max_sweeps = found_all ? kLastSweeps : std::max(kLastSweeps, options.max_sweeps);
  const Report last = sweeps(offset, target, options, impulse, v);
  report.sweeps += last.sweeps;
  if (last.converged || (!found_all && last.residual < std::min(at_once, report.residual))) {
    report.residual = last.residual, report.converged = last.converged;
  } else if (at_once < report.residual) {
    report.residual = at_once, report.converged = at_once <= options.tolerance;
    take(found, v_found);
  } else {
    take(swept, v_swept);
  }
}

Eigen::MatrixXd ProjectedGaussSeidel::responses(std::size_t width) const {
  const std::size_t n = size();
  Eigen::MatrixXd W(3 * n, 3 * n);
  std::vector<double> answer(width);
  for (std::size_t c = 0; c < n; ++c)
    for (int k = 0; k < 3; ++k) {
      std::fill(answer.begin(), answer.end(), 0.0);
      add_response(c, Vec3::Unit(k), answer);
      const auto column = static_cast<Eigen::Index>(3 * c) + k;
      for (std::size_t d = 0; d < n; ++d) W.block<3, 1>(static_cast<Eigen::Index>(3 * d), column) = velocity(d, answer);
    }
  return W;
}

}  // namespace brim
