// Refinement in ConstraintStep when the sweeps know the bodies only approximately: they propose a direction in λ, the
// step's own solve tells its response, and the sweeps learn it for the next one.
#include <algorithm>
#include <cmath>

#include "brim/world/constraint_step.h"

namespace brim {

namespace {

/// Minimum step of the line search.
constexpr double kLeastWay = 0.02;
/// Longest step of the line search: contact may make a body as many times harder to move than it is alone.
constexpr double kLongestWay = 100.0;
/// Tolerance of a direction's solve relative to that of the step, where all rows are between rigid bodies: the next
/// direction mends what it leaves, and momentum is given back. What the sweeps learn is as rough: at 100 a light box
/// between a jelly and a heavy box takes twice as many solves, at 1 mixed_stack a tenth more iterations in all.
constexpr double kRigidSolves = 20.0;
/// Tolerance of the refinement, relative to that of the sweeps.
constexpr double kRefined = 30.0;
/// Tolerance of the sweeps that find a direction, relative to the remaining error; maximum number of sweeps.
constexpr double kRough = 0.1;
constexpr int kRoughSweeps = 200;

}  // namespace

void ConstraintStep::refine(const ImplicitStep::Respond& solve, std::span<const double> target, int most,
                            std::vector<Vec3>& lambda, std::vector<double>& delta, double& residual,
                            StepReport& report) {
  const std::size_t n = lambda.size(), nv = first_v_.back();
  // A direction in λ, what the sweeps expect of it at every contact, and its true effect there and on the velocities.
  std::vector<Vec3> way(n, Vec3::Zero()), expected(n, Vec3::Zero()), actual(n, Vec3::Zero());
  std::vector<double> way_v(width_, 0.0);
  std::vector<Vec3> offset(n), next;
  std::vector<double> change, rhs(nv);
  const bool any_known = std::ranges::find(known_, 1) != known_.end();
  double scale = settings_.scale, left = 0.0;  // left: residual of the known points
  for (int i = 0; i < most; ++i) {
    for (std::size_t c = 0; c < n; ++c) offset[c] = offset_[c] + sweep_.velocity(c, delta);
    next = lambda;
    change.assign(width_, 0.0);
    const bool finishes = i == 0 && any_known;
    const ProjectedGaussSeidel::SweepOptions options{
        .tolerance = finishes ? settings_.tolerance : kRough * std::max(settings_.tolerance, i == 0 ? 0.0 : residual),
        .max_sweeps = finishes ? most_sweeps_ : std::min(settings_.max_sweeps, kRoughSweeps),
        .scale = scale,
        .may_at_once = finishes};
    const auto r = sweep_.solve(offset, target, options, next, change);
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
      expected[c] = sweep_.velocity(c, change);
      worst = std::max(worst, expected[c].norm());
      way[c] = next[c] - lambda[c];
      sweep_.add_force(c, way[c], rhs);
    }
    if (i == 0) scale = std::max(scale, worst);
    residual = worst / scale;
    if (!(residual > kRefined * settings_.tolerance)) break;
    std::fill(way_v.begin(), way_v.end(), 0.0);
    const SolveReport s = solve(rhs, std::span(way_v).first(nv), mapped_ ? 1.0 : kRigidSolves);
    report.cg_iterations += s.iterations;
    ++report.solves;
    if (!s.finite) break;
    for (std::size_t c = 0; c < n; ++c) actual[c] = sweep_.velocity(c, way_v);

    // What the sweeps expect is what is left to correct: it predicts the best length of the way.
    double curvature = 0.0, down = 0.0;
    for (std::size_t c = 0; c < n; ++c) curvature += way[c].dot(actual[c]), down += way[c].dot(expected[c]);
    const double best = curvature > 0.0 ? std::clamp(down / curvature, kLeastWay, kLongestWay) : 1.0;
    const double t = longest_way(lambda, way, best);
    for (std::size_t c = 0; c < n; ++c) lambda[c] += t * way[c];
    for (std::size_t j = 0; j < nv; ++j) delta[j] += t * way_v[j];
    sweep_.learn(way, expected, actual);
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
