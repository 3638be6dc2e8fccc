#include "brim/world/constraint_step.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "brim/core/parallel.h"
#include "brim/world/ball_points.h"
#include "brim/world/momentum_check.h"

namespace brim {

namespace {

/// Maximum number of solves with A when its inverse is unknown: for velocities, and for displacements that differ.
constexpr int kMostRefinements = 40, kPositionRefinements = 10;
/// With more connected points of rigid pairs the number of sweeps decreases in proportion, down to this share: warm
/// starts continue the solution from step to step, and the cost stays linear. A residual the size of a free fall's
/// motion gives a warning.
constexpr double kManyPoints = 100.0, kLeastSweeps = 0.1, kLarge = 1.0;
/// Sweeps of position correction: the remaining error is left to the next step.
constexpr double kPushTolerance = 1e-2;
constexpr int kPushSweeps = 10;
/// How often friction of sliding faces is moved to the centre of their load: loads that the motion does not determine
/// change a little with it.
constexpr int kMostCentered = 2;
/// Points that are connected, up to which it is: in heaps that fall, sweeps do not converge again within a step.
constexpr std::size_t kFewPoints = 16;
/// Residual relative to the tolerance that gives a warning.
constexpr double kWarn = 100.0;
/// How often sweeps that end above it are continued, each time by as many: one sub-step in some thousand.
constexpr int kMostMore = 4;

/// Fastest motion of a body, relative to the largest displacement that a row of its island asks for.
constexpr double kMostPushed = 10.0;

/// Slows bodies that would move much farther than the rows of their island ask for: a leg that stands a thousandth of a
/// radian off its dead centre would turn round to rise by a tenth of a voxel.
/// @param asked  [m/s] by each row  @param way  [m/s] displacements over the step, changed in place
/// @param meant  per body: its way is not that of a push alone
void bound_push(std::span<const WorldPart> parts, const ContactSet& points, Islands islands,
                std::span<const double> asked, std::span<const std::size_t> first_v,
                std::span<const std::uint8_t> meant, std::span<double> way) {
  const std::size_t bodies = first_v.size() - 1;
  std::vector<double> most(bodies, 0.0), motion(bodies, 0.0);
  for (const ContactPair& pair : points.pairs)
    for (const std::int32_t part : {pair.part_a, pair.part_b})
      for (std::size_t c = pair.begin; c < pair.end && !is_fixed(parts[part]); ++c) {
        double& m = most[static_cast<std::size_t>(islands.first_of(parts[part].body_index))];
        m = std::max(m, asked[c]);
      }
  for (const WorldPart& p : parts) {
    double& m = motion[static_cast<std::size_t>(p.body_index)];
    if (!is_fixed(p)) m = std::max(m, speed_bound(p, velocities_of(p, way, first_v)));
  }
  for (std::size_t b = 0; b < bodies; ++b) {
    const double limit = kMostPushed * most[static_cast<std::size_t>(islands.first_of(static_cast<std::int32_t>(b)))];
    if (meant[b] || !(motion[b] > limit)) continue;
    for (std::size_t i = first_v[b]; i < first_v[b + 1]; ++i) way[i] *= limit / motion[b];
  }
}

/// Rows n, t1, t2 of a right-handed frame.
Mat3 frame_along(const Vec3& n) {
  Eigen::Index least = 0;
  n.cwiseAbs().minCoeff(&least);
  const Vec3 t1 = n.cross(Vec3::Unit(least)).normalized();
  Mat3 f;
  f << n.transpose(), t1.transpose(), n.cross(t1).transpose();
  return f;
}

}  // namespace

void ConstraintStep::begin(std::span<const std::unique_ptr<Body>> bodies, std::span<const std::size_t> first_v,
                           std::span<const WorldPart> parts, const ContactSet& contacts, std::span<const Vec3> normals,
                           std::span<const ConstraintPair> pairs, const GatheredRows& gathered,
                           std::span<const double> v, const Settings& settings, std::span<const double> memory) {
  bodies_ = bodies, first_v_ = first_v, parts_ = parts, settings_ = settings;
  position_correction_.clear();
  rows_.gather(contacts, normals, pairs, settings.rows, gathered);
  const ContactSet& points = rows_.points();
  const std::size_t n = points.size();
  apart_.resize(n);
  for (std::size_t c = 0; c < n; ++c) apart_[c] = rows_.grips()[c] != points.point[c];
  place_under_balls(parts, rows_.normals(), rows_.points());
  impulse_.assign(v.size(), 0.0);
  lambda_.assign(n, Vec3::Zero());
  if (n == 0) return;

  mark_bodies(contacts, pairs, gathered);
  ways_.assign(points.pairs.size(), {});
  find_round_impacts(v);
  follow_curves(v);
  most_sweeps_ = find_most_sweeps();
  if (mapped_) build_maps();
  frame_.resize(n), offset_.resize(n);
  for (std::size_t c = 0; c < n; ++c) frame_[c] = frame_along(rows_.normals()[c]);
  find_start(v);
  recall(memory);
  guess_ = lambda_;
  force_on_a_.resize(n);
  for (std::size_t c = 0; c < n; ++c) force_on_a_[c] = frame_[c].transpose() * lambda_[c];
  add_forces(force_on_a_, impulse_);
}

bool ConstraintStep::correct(const ImplicitStep::Respond& solve, std::span<double> delta, std::span<double> added,
                             StepReport& report) {
  if (empty()) return true;
  assemble();
  const std::size_t n = rows_.points().size();
  std::vector<double> change(delta.begin(), delta.end()), response(width_, 0.0);
  change.resize(width_, 0.0);
  direct_.read(first_v_, change);
  position_correction_.clear();
  for (std::size_t c = 0; c < n; ++c) sweep_.add_response(c, lambda_[c], response);
  std::vector<Vec3> free(n);
  for (std::size_t c = 0; c < n; ++c)
    free[c] = start_[c] + frame_[c].transpose() * (sweep_.velocity(c, change) - sweep_.velocity(c, response));
  rows_.set_targets(settings_.rows, start_, free, lift_);
  if (rows_.bounces()) {
    std::vector<double> without = change;
    for (std::size_t i = 0; i < width_; ++i) without[i] -= response[i];
    pass_impacts_on(std::move(without));
  }

  double residual = 0.0;
  const int refinements = (kMostRefinements * most_sweeps_ + settings_.max_sweeps - 1) / settings_.max_sweeps;
  solve_rows(solve, rows_.velocity_targets(), refinements, lambda_, change, residual, report);
  const bool centers = exact_ && most_together() <= kFewPoints;
  for (int i = 0; centers && i < kMostCentered && center_friction(lambda_, change, added); ++i)
    solve_rows(solve, rows_.velocity_targets(), refinements, lambda_, change, residual, report);
  converged_ = !(residual > warn_above());
  if (!converged_)
    report.warnings.push_back(
        {report.time, "no_convergence",
         fmt::format("the constraint rows of {} contacts stopped at relative residual {:.1e}; allow more sweeps", n,
                     residual)});
  // The sweeps represent factored bodies by their contacts only.
  const auto complete = [&](std::span<const Vec3> lambda, std::span<double> v) {
    std::vector<Vec3> more(n);
    for (std::size_t c = 0; c < n; ++c) more[c] = lambda[c] - guess_[c];
    direct_.respond(inverses_, first_v_, more, v);
  };
  if (rows_.targets_differ()) {
    std::vector<Vec3> lambda = lambda_;
    std::vector<double> way = change;
    const std::vector<std::uint8_t> along = go_along_curves(lambda, way);
    const double worst = report.row_residual;
    if (solids_ && exact_ && (!rows_.breaks() || follow_bends(lambda, way)))
      push_apart(lambda, way, report);
    else
      solve_rows(solve, rows_.position_targets(), kPositionRefinements, lambda, way, residual, report);
    report.row_residual = worst;
    complete(lambda, way);
    complete(lambda_, change);
    position_correction_.resize(delta.size());
    for (std::size_t i = 0; i < position_correction_.size(); ++i) position_correction_[i] = way[i] - change[i];
    std::vector<double> asked(n);
    for (std::size_t c = 0; c < n; ++c) asked[c] = std::abs(rows_.position_targets()[c] - rows_.velocity_targets()[c]);
    bound_push(parts_, rows_.points(), join_rows(), asked, first_v_, along, position_correction_);
  } else {
    complete(lambda_, change);
  }
  if (!added.empty()) {
    for (std::size_t c = 0; c < n; ++c) force_on_a_[c] = frame_[c].transpose() * (lambda_[c] - guess_[c]);
    add_forces(force_on_a_, added);
    guess_ = lambda_;
  }
  bool finite = true;
  for (std::size_t i = 0; i < delta.size(); ++i) {
    delta[i] = change[i];
    finite =
        finite && std::isfinite(delta[i]) && (position_correction_.empty() || std::isfinite(position_correction_[i]));
  }
  return finite;
}

double ConstraintStep::warn_above() const {
  // Many points are not swept to convergence within a step, but over several.
  return most_sweeps_ == settings_.max_sweeps ? kWarn * settings_.tolerance : kLarge;
}

void ConstraintStep::solve_rows(const ImplicitStep::Respond& solve, std::span<const double> target, int most,
                                std::vector<Vec3>& lambda, std::vector<double>& delta, double& residual,
                                StepReport& report) {
  if (!exact_) return refine(solve, target, most, lambda, delta, residual, report);
  // Solids alone are swept on, and solved at once only where that does not help.
  const bool pairs_only = sweep_.pairs_only();
  ProjectedGaussSeidel::SweepOptions options{.tolerance = settings_.tolerance,
                                             .max_sweeps = most_sweeps_,
                                             .scale = settings_.scale,
                                             .may_at_once = !pairs_only};
  auto r = sweep_.solve(offset_, target, options, lambda, delta);
  report.sweeps += r.sweeps;
  for (int more = 0; more < kMostMore && r.residual > warn_above(); ++more) {
    options.scale = r.scale;
    if (pairs_only) options.max_sweeps = settings_.max_sweeps, options.may_at_once = more + 1 == kMostMore;
    r = sweep_.solve(offset_, target, options, lambda, delta);
    report.sweeps += r.sweeps;
  }
  report.row_residual = std::max(report.row_residual, r.residual);
  residual = r.residual;
}

Islands ConstraintStep::join_rows() const {
  Islands islands(bodies_.size());
  for (const ContactPair& p : rows_.points().pairs)
    if (p.begin < p.end && !is_fixed(parts_[p.part_a]) && !is_fixed(parts_[p.part_b]))
      islands.join(parts_[p.part_a].body_index, parts_[p.part_b].body_index);
  return islands;
}

std::size_t ConstraintStep::most_together() const {
  Islands islands = join_rows();
  std::vector<std::size_t> together(bodies_.size(), 0);
  for (const ContactPair& p : rows_.points().pairs) together[islands.first_of(moving_body(p))] += p.end - p.begin;
  return *std::ranges::max_element(together);
}

int ConstraintStep::find_most_sweeps() const {
  if (mapped_) return settings_.max_sweeps;
  const double share = kManyPoints / static_cast<double>(std::max<std::size_t>(1, most_together()));
  return static_cast<int>(settings_.max_sweeps * std::clamp(share, kLeastSweeps, 1.0));
}

void ConstraintStep::push_apart(std::vector<Vec3>& lambda, std::vector<double>& way, StepReport& report) {
  const std::size_t n = rows_.points().size();
  std::vector<Vec3> at(n), push(n, Vec3::Zero());
  for (std::size_t c = 0; c < n; ++c) at[c] = offset_[c] + sweep_.velocity(c, way);
  std::vector<double> change(width_, 0.0);
  const ProjectedGaussSeidel::SweepOptions options{.tolerance = kPushTolerance,
                                                   .max_sweeps = kPushSweeps,
                                                   .scale = settings_.scale,
                                                   .friction = 0.0,
                                                   .may_at_once = false};
  const auto r = sweep_.solve(at, rows_.position_targets(), options, push, change);
  report.sweeps += r.sweeps;
  for (std::size_t c = 0; c < n; ++c) lambda[c] += push[c];
  for (std::size_t i = 0; i < width_; ++i) way[i] += change[i];
}

void ConstraintStep::finish(StepReport& report, std::vector<ContactSample>& samples, bool check,
                            std::vector<double>& memory) const {
  const ContactSet& points = rows_.points();
  memory.clear();
  std::vector<Vec3> force(points.size());
  std::size_t at = 0;
  for (const ContactPair& pair : points.pairs) {
    if (pair.begin == pair.end) continue;
    while (at < report.pairs.size() &&
           (report.pairs[at].part_a != pair.part_a || report.pairs[at].part_b != pair.part_b))
      ++at;
    if (at == report.pairs.size()) break;
    PairReport& r = report.pairs[at];
    Vec3 center = Vec3::Zero();
    double load = 0.0;
    for (std::size_t c = pair.begin; c < pair.end; ++c) {
      const Vec3 f = frame_[c].transpose() * lambda_[c] / settings_.rows.dt;
      const Vec3 normal = lambda_[c].x() / settings_.rows.dt * rows_.normals()[c], &x = points.point[c];
      force[c] = f;
      r.force_on_a += f;
      r.friction_on_a += f - normal;
      center += normal.norm() * x;
      load += normal.norm();
      samples.push_back({x.cast<float>(), normal.cast<float>(), Vec3(f - normal).cast<float>(),
                         static_cast<float>(points.depth[c] / pair.h), pair.part_a, pair.part_b});
      RowMemory::keep(pair, x, f, memory);
    }
    if (load > 0.0) r.center = center / load;
  }
  if (!check || points.size() == 0) return;
  std::vector<double> mapped(first_v_.back(), 0.0);
  add_forces(force, mapped);
  // Where friction acts at another point, it is an entry of its own.
  ContactSet acting;
  std::vector<Vec3> forces;
  for (std::size_t p = 0; p < points.pairs.size(); ++p) {
    const ContactPair& pair = points.pairs[p];
    acting.pairs.push_back(pair);
    acting.pairs.back().begin = forces.size();
    const auto add = [&](const Vec3& x, const Vec3& f) {
      acting.point.push_back(x - ways_[p].a), acting.link_point_b.push_back(x - ways_[p].b);
      forces.push_back(f);
    };
    for (std::size_t c = pair.begin; c < pair.end; ++c) {
      const Vec3& n = rows_.normals()[c];
      const bool apart = apart_[c] != 0;
      const Vec3 along = apart ? Vec3(n * n.dot(force[c])) : force[c];
      add(points.point[c], along);
      if (apart) add(rows_.grips()[c], force[c] - along);
    }
    acting.pairs.back().end = forces.size();
  }
  check_momentum(bodies_, first_v_, parts_, acting, mapped, forces, report);
}

}  // namespace brim
