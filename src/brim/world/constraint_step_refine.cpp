// Refinement in ConstraintStep when the sweeps know the bodies only approximately: they propose a direction in λ, the
// step's own solve tells its response, and the sweeps learn it for the next one.
#include <algorithm>
#include <cmath>

#include "brim/solve/contact_admm.h"
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
/// Directions after which islands that are not done are solved by their columns; iterations of a solve that is a direct
/// one, and contacts of an island up to which these are worth so many solves.
constexpr int kStubborn = 20, kDirect = 2;
constexpr std::size_t kMostColumns = 40;
/// Iterations with the columns.
constexpr int kMostAtOnceIterations = 1000;
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
  // Islands do not know of each other: each has its own scale, length of the way, and end.
  std::vector<Refined> islands(islands_, {.scale = settings_.scale});
  std::vector<double> worst(islands_), curvature(islands_), down(islands_), t(islands_);
  std::vector<std::uint8_t> skipped;  // known points after the first round, and those of islands that are done
  residual = 0.0;
  double left = 0.0, largest = settings_.scale;  // left: residual of the known points
  for (int i = 0; i < most; ++i) {
    for (std::size_t c = 0; c < n; ++c) offset[c] = offset_[c] + sweep_.velocity(c, delta);
    next = lambda;
    change.assign(width_, 0.0);
    const bool finishes = i == 0 && any_known;
    const ProjectedGaussSeidel::SweepOptions options{
        .tolerance = finishes ? settings_.tolerance : kRough * std::max(kRefined * settings_.tolerance, residual),
        .max_sweeps = finishes ? most_sweeps_ : std::min(settings_.max_sweeps, kRoughSweeps),
        .scale = largest,
        .may_at_once = finishes,
        .skipped = skipped};
    const auto r = sweep_.solve(offset, target, options, next, change);
    report.sweeps += r.sweeps;
    // With many points the sweeps converge over several steps.
    if (finishes && most_sweeps_ == settings_.max_sweeps) left = r.residual;

    std::ranges::fill(worst, 0.0);
    std::ranges::fill(rhs, 0.0);
    for (std::size_t c = 0; c < n; ++c) {
      if (known_[c]) {
        if (finishes) sweep_.add_response(c, next[c] - lambda[c], delta), lambda[c] = next[c];
        continue;
      }
      expected[c] = sweep_.velocity(c, change);
      worst[island_[c]] = std::max(worst[island_[c]], expected[c].norm());
    }
    residual = 0.0;
    for (std::size_t k = 0; k < islands_; ++k) {
      Refined& island = islands[k];
      if (i == 0) island.scale = std::max(island.scale, worst[k]), largest = std::max(largest, island.scale);
      if (island.done) continue;
      island.missed = worst[k] / island.scale;
      island.done = !(island.missed > kRefined * settings_.tolerance);
      if (!island.done) residual = std::max(residual, island.missed);
    }
    if (std::ranges::all_of(islands, &Refined::done)) break;
    skipped.resize(n);
    for (std::size_t c = 0; c < n; ++c) skipped[c] = known_[c] || islands[island_[c]].done;
    for (std::size_t c = 0; c < n; ++c) {
      if (known_[c]) continue;
      const bool done = islands[island_[c]].done;
      way[c] = done ? Vec3(Vec3::Zero()) : Vec3(next[c] - lambda[c]);
      if (done) expected[c].setZero();
      sweep_.add_force(c, way[c], rhs);
    }
    std::fill(way_v.begin(), way_v.end(), 0.0);
    const SolveReport s = solve(rhs, std::span(way_v).first(nv), mapped_ ? 1.0 : kRigidSolves);
    report.cg_iterations += s.iterations;
    ++report.solves;
    if (!s.finite) break;
    for (std::size_t c = 0; c < n; ++c) actual[c] = sweep_.velocity(c, way_v);

    // What the sweeps expect is what is left to correct: it predicts the best length of the way.
    std::ranges::fill(curvature, 0.0), std::ranges::fill(down, 0.0);
    for (std::size_t c = 0; c < n; ++c) {
      if (known_[c]) continue;
      curvature[island_[c]] += way[c].dot(actual[c]), down[island_[c]] += way[c].dot(expected[c]);
    }
    for (std::size_t k = 0; k < islands_; ++k) {
      const double best = curvature[k] > 0.0 ? std::clamp(down[k] / curvature[k], kLeastWay, kLongestWay) : 1.0;
      t[k] = islands[k].done ? 0.0 : longest_way(static_cast<std::int32_t>(k), lambda, way, best);
    }
    for (std::size_t c = 0; c < n; ++c)
      if (!known_[c]) lambda[c] += t[island_[c]] * way[c];
    for (std::size_t b = 0; b < bodies_.size(); ++b)
      for (std::size_t j = first_v_[b]; j < first_v_[b + 1]; ++j) delta[j] += t[island_of_body_[b]] * way_v[j];
    sweep_.learn(way, expected, actual);
    if (i + 1 == kStubborn) {
      const auto affordable = static_cast<std::size_t>(std::max(0, most - kStubborn)) / 3;
      solve_columns(solve, target, s.iterations <= kDirect ? kMostColumns : std::min(kMostColumns, affordable), islands,
                    lambda, delta, report);
    }
  }
  residual = left;
  for (const Refined& island : islands) residual = std::max(residual, island.missed);
  report.row_residual = std::max(report.row_residual, residual);
}

void ConstraintStep::solve_columns(const ImplicitStep::Respond& solve, std::span<const double> target, std::size_t most,
                                   std::span<Refined> islands, std::vector<Vec3>& lambda, std::vector<double>& delta,
                                   StepReport& report) {
  std::vector<std::vector<std::size_t>> points(islands_);
  for (std::size_t c = 0; c < lambda.size(); ++c)
    if (!known_[c] && !islands[island_[c]].done) points[island_[c]].push_back(c);
  std::size_t largest = 0;
  for (auto& own : points) {
    if (own.size() > most) own.clear();
    largest = std::max(largest, own.size());
  }
  if (largest == 0) return;
  const std::size_t nv = first_v_.back();
  std::vector<double> rhs(nv), answer(width_, 0.0);
  const auto respond = [&] {
    const SolveReport s = solve(rhs, std::span(answer).first(nv), 1.0);
    report.cg_iterations += s.iterations;
    ++report.solves;
    return s.finite;
  };
  // One solve gives a column of every island.
  std::vector<Eigen::MatrixXd> W(islands_);
  for (std::size_t k = 0; k < islands_; ++k)
    W[k].resize(static_cast<Eigen::Index>(3 * points[k].size()), static_cast<Eigen::Index>(3 * points[k].size()));
  for (std::size_t j = 0; j < 3 * largest; ++j) {
    std::ranges::fill(rhs, 0.0);
    for (const auto& own : points)
      if (j < 3 * own.size()) sweep_.add_force(own[j / 3], Vec3::Unit(static_cast<Eigen::Index>(j % 3)), rhs);
    if (!respond()) return;
    for (std::size_t k = 0; k < islands_; ++k)
      for (std::size_t d = 0; d < points[k].size() && j < 3 * points[k].size(); ++d)
        W[k].col(static_cast<Eigen::Index>(j)).segment<3>(static_cast<Eigen::Index>(3 * d)) =
            sweep_.velocity(points[k][d], answer);
  }
  std::ranges::fill(rhs, 0.0);
  for (std::size_t k = 0; k < islands_; ++k) {
    const std::vector<std::size_t>& own = points[k];
    if (own.empty()) continue;
    const Eigen::MatrixXd both = 0.5 * (W[k] + W[k].transpose());
    ContactResponses responses;
    std::vector<ContactEntry> entries;
    std::vector<Vec3> q(own.size()), impulse(own.size());
    std::vector<double> friction(own.size());
    for (std::size_t d = 0; d < own.size(); ++d) impulse[d] = lambda[own[d]];
    for (std::size_t d = 0; d < own.size(); ++d) {
      const auto at = static_cast<Eigen::Index>(3 * d);
      entries.clear();
      for (std::size_t i = 0; i < 3 * own.size(); ++i)
        entries.push_back({i, i / 3 == d ? Vec3(Vec3::Unit(static_cast<Eigen::Index>(i % 3))) : Vec3(Vec3::Zero()),
                           both.row(static_cast<Eigen::Index>(i)).segment<3>(at).transpose()});
      responses.add(entries);
      q[d] = offset_[own[d]] + sweep_.velocity(own[d], delta);
      q[d].x() -= target[own[d]];
      for (std::size_t e = 0; e < own.size(); ++e)
        q[d] -= both.block<3, 3>(at, static_cast<Eigen::Index>(3 * e)) * impulse[e];
      friction[d] = rows_.friction()[own[d]];
    }
    const auto r = ContactAdmm::solve(responses, q, friction, settings_.tolerance * islands[k].scale,
                                      kMostAtOnceIterations, impulse);
    report.sweeps += r.iterations;
    if (!r.converged) continue;
    islands[k].done = true, islands[k].missed = 0.0;
    for (std::size_t d = 0; d < own.size(); ++d) {
      sweep_.add_force(own[d], impulse[d] - lambda[own[d]], rhs);
      lambda[own[d]] = impulse[d];
    }
  }
  if (!respond()) return;
  for (std::size_t j = 0; j < nv; ++j) delta[j] += answer[j];
}

double ConstraintStep::longest_way(std::int32_t island, std::span<const Vec3> from, std::span<const Vec3> way,
                                   double most) const {
  const auto inside = [&](std::size_t c, double t) {
    const Vec3 l = from[c] + t * way[c];
    const double room = 1e-12 * (1.0 + from[c].norm());
    return l.x() >= -room && l.tail<2>().norm() <= rows_.friction()[c] * l.x() + room;
  };
  // The cones are convex: points between two inside points are inside. The end of a swept direction is.
  const auto all_inside = [&](double t) {
    for (std::size_t c = 0; c < from.size(); ++c)
      if (island_[c] == island && !inside(c, t)) return false;
    return true;
  };
  if (most > 1.0 && !all_inside(most)) most = 1.0;
  for (std::size_t c = 0; c < from.size(); ++c)
    while (island_[c] == island && most > kLeastWay && !inside(c, most)) most *= 0.8;
  return most;
}

}  // namespace brim
