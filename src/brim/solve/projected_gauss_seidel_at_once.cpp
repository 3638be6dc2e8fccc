// All contacts of ProjectedGaussSeidel at once, where sweeps do not converge.
#include <algorithm>

#include "brim/solve/contact_admm.h"
#include "brim/solve/contact_cone.h"
#include "brim/solve/projected_gauss_seidel.h"

namespace brim {

namespace {

/// Iterations at most, and sweeps after them.
constexpr int kIterations = 1000, kLastSweeps = 2;

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
  const ContactResponses W = responses(v.size());
  report.sweeps += ContactAdmm::solve(W, q, mu, options.tolerance * options.scale, kIterations, impulse).iterations;
  for (std::size_t c = 0; c < n; ++c) add_response(c, impulse[c] - swept[c], v);
  double worst = 0.0;
  for (std::size_t c = 0; c < n; ++c) {
    const Mat3 own = W.local(c);
    if (!(own(0, 0) > 0.0)) continue;
    Vec3 u = velocity(c, v) + offset[c];
    u.x() -= target[c];
    worst = std::max(worst, contact_residual(own.trace() / 3.0, mu[c], u, impulse[c]));
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

ContactResponses ProjectedGaussSeidel::responses(std::size_t width) const {
  ContactResponses all;
  std::vector<Entry> entries;
  std::vector<double> row(width), response(width);
  const auto gather = [&](std::size_t first, std::size_t count) {
    for (std::size_t i = first; i < first + count; ++i) entries.push_back({i, Vec3::Zero(), Vec3::Zero()});
  };
  for (std::size_t c = 0; c < size(); ++c) {
    entries.clear();
    const std::size_t r = place_[c].row;
    if (place_[c].rigid) {
      const auto [a, b] = pairs_.bodies(pairs_.pair_of(r));
      for (const std::size_t first : {a, b})
        if (first != RigidPairRows::kFixed) gather(first, 6);
    } else {
      for (std::size_t k = first_run_[r]; k < first_run_[r + 1]; ++k) gather(runs_[k].index, runs_[k].size);
    }
    for (int k = 0; k < 3; ++k) {
      for (const Entry& e : entries) row[e.index] = response[e.index] = 0.0;
      add_force(c, Vec3::Unit(k), row);
      add_response(c, Vec3::Unit(k), response);
      for (Entry& e : entries) e.row[k] = row[e.index], e.response[k] = response[e.index];
    }
    if (!place_[c].rigid)
      for (std::size_t k = 0; k < learned_columns_; ++k) {
        const Vec3 column = learned_[r * kLearned + k];
        entries.push_back({first_learned_[r] + k, column, k % 2 == 0 ? Vec3(-column) : column});
      }
    all.add(entries);
  }
  return all;
}

}  // namespace brim
