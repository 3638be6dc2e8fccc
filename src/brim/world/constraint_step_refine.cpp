// Refinement in ConstraintStep when the sweeps know the bodies only approximately: by directions in λ whose response
// comes from the step's own solve.
#include <algorithm>
#include <cmath>

#include "brim/world/constraint_step.h"

namespace brim {

namespace {

/// Minimum step of the line search.
constexpr double kLeastWay = 0.02;
/// Longest step of the line search: contact may make a body as many times harder to move than it is alone.
constexpr double kLongestWay = 100.0;
/// Smallest share of a direction's curvature after it is made conjugate to the last: below it the two are parallel and
/// the rest is the error of their solves. At 1e-8 mixed_stack takes a tenth more solves.
constexpr double kIndependent = 1e-3;
/// Tolerance of a direction's solve relative to that of the step, where all rows are between rigid bodies: the next
/// direction mends what it leaves, and momentum is given back. At 1 mixed_stack takes twice the iterations.
constexpr double kRigidSolves = 100.0;
/// Tolerance of the refinement, relative to that of the sweeps.
constexpr double kRefined = 30.0;
/// Tolerance of the sweeps that find a direction, relative to the remaining error; maximum number of sweeps.
constexpr double kRough = 0.1;
constexpr int kRoughSweeps = 30;

}  // namespace

void ConstraintStep::refine(const ImplicitStep::Respond& solve, std::span<const double> target, int most,
                            std::vector<Vec3>& lambda, std::vector<double>& delta, double& residual,
                            StepReport& report) {
  const std::size_t n = lambda.size(), nv = first_v_.back();
  // Effect of a direction in λ: on the velocities, and on u at every contact.
  struct Direction {
    std::vector<Vec3> lambda, u;
    std::vector<double> v;
    double curvature = 0.0;  ///< λ·u
  };
  Direction now, last;
  std::vector<Vec3> offset(n), next, change_u(n, Vec3::Zero());
  std::vector<double> change, rhs(nv);
  now.lambda.assign(n, Vec3::Zero()), now.u.assign(n, Vec3::Zero()), now.v.resize(width_);
  const bool any_known = std::ranges::find(known_, 1) != known_.end();
  double scale = settings_.scale, left = 0.0;  // left: residual of the known points
  for (int i = 0; i < most; ++i) {
    for (std::size_t c = 0; c < n; ++c) offset[c] = offset_[c] + sweep_.velocity(c, delta);
    next = lambda;
    change.assign(width_, 0.0);
    const bool finishes = i == 0 && any_known;
    const auto r = sweep_.solve(
        offset, target,
        finishes ? settings_.tolerance : kRough * std::max(settings_.tolerance, i == 0 ? 0.0 : residual),
        finishes ? most_sweeps_ : std::min(settings_.max_sweeps, kRoughSweeps), scale, next, change, 1.0, finishes);
    report.sweeps += r.sweeps;
    // With many points the sweeps converge over several steps.
    if (finishes && most_sweeps_ == settings_.max_sweeps) left = r.residual;

    double worst = 0.0;
    std::fill(rhs.begin(), rhs.end(), 0.0);
    for (std::size_t c = 0; c < n; ++c) {
      if (known_[c]) {
        if (finishes) sweep_.add_response(c, next[c] - lambda[c], delta), lambda[c] = next[c];
        continue;
      }
      change_u[c] = sweep_.velocity(c, change);
      worst = std::max(worst, change_u[c].norm());
      now.lambda[c] = next[c] - lambda[c];
      sweep_.add_force(c, now.lambda[c], rhs);
    }
    if (i == 0) scale = std::max(scale, worst);
    residual = worst / scale;
    if (!(residual > kRefined * settings_.tolerance)) break;
    std::fill(now.v.begin(), now.v.end(), 0.0);
    const SolveReport s = solve(rhs, std::span(now.v).first(nv), mapped_ ? 1.0 : kRigidSolves);
    report.cg_iterations += s.iterations;
    ++report.solves;
    if (!s.finite) break;
    for (std::size_t c = 0; c < n; ++c) now.u[c] = sweep_.velocity(c, now.v);

    // Made conjugate to the last direction, unless that leaves a cone; the model predicts the decrease along it.
    double t = 0.0;
    const auto measure = [&](Direction& d) {
      double down = 0.0;
      d.curvature = 0.0;
      for (std::size_t c = 0; c < n; ++c) d.curvature += d.lambda[c].dot(d.u[c]), down += d.lambda[c].dot(change_u[c]);
      t = d.curvature > 0.0 ? std::clamp(down / d.curvature, 0.0, kLongestWay) : 1.0;
    };
    measure(now);
    bool conjugate = last.curvature > 0.0;
    if (conjugate) {
      double shared = 0.0;
      for (std::size_t c = 0; c < n; ++c) shared += now.lambda[c].dot(last.u[c]);
      const double beta = -shared / last.curvature;
      for (std::size_t c = 0; c < n; ++c)
        last.lambda[c] = now.lambda[c] + beta * last.lambda[c], last.u[c] = now.u[c] + beta * last.u[c];
      for (std::size_t j = 0; j < nv; ++j) last.v[j] = now.v[j] + beta * last.v[j];
      measure(last);
      conjugate =
          last.curvature > kIndependent * now.curvature && t > 0.0 && longest_way(lambda, last.lambda, t) >= 0.999 * t;
    }
    if (conjugate) {
      now = last;
    } else {
      measure(now);
      t = longest_way(lambda, now.lambda, std::max(t, kLeastWay));
    }
    for (std::size_t c = 0; c < n; ++c) lambda[c] += t * now.lambda[c];
    for (std::size_t j = 0; j < nv; ++j) delta[j] += t * now.v[j];
    last = now;
  }
  residual = std::max(residual, left);
  report.row_residual = std::max(report.row_residual, residual);
}

double ConstraintStep::longest_way(std::span<const Vec3> from, std::span<const Vec3> way, double most) const {
  const auto inside = [&](std::size_t c, double t) {
    const Vec3 l = from[c] + t * way[c];
    const double room = 1e-12 * (1.0 + from[c].norm());
    return l.x() >= -room && l.tail<2>().norm() <= rows_.friction()[c] * l.x() + room;
  };
  // The cones are convex: points between two inside points are inside. The end of a swept direction is.
  const auto all_inside = [&](double t) {
    for (std::size_t c = 0; c < from.size(); ++c)
      if (!inside(c, t)) return false;
    return true;
  };
  if (most > 1.0 && !all_inside(most)) most = 1.0;
  for (std::size_t c = 0; c < from.size(); ++c)
    while (most > kLeastWay && !inside(c, most)) most *= 0.8;
  return most;
}

}  // namespace brim
