#include "brim/solve/projected_gauss_seidel.h"

#include <algorithm>
#include <cmath>

#include "brim/core/parallel.h"
#include "brim/core/simd.h"
#include "brim/core/stop.h"
#include "brim/solve/contact_cone.h"

namespace brim {

namespace {

/// Rounds over the contacts of a rigid pair each time that a sweep comes to it.
constexpr int kRounds = 2;
/// Contacts up to which all are solved at once: their responses are a dense matrix. Sweeps before that: what few do not
/// settle, many hardly do.
constexpr std::size_t kMostAtOnce = 400;
constexpr int kFewSweeps = 30;
/// Residual over the tolerance above which contacts of rigid pairs alone are solved at once, after all their sweeps:
/// below it the next step goes on where this one ends.
constexpr double kFarOff = 100.0;

/// Pairs of rigid bodies from which on threads share them, if there are so many to a layer in the mean; those that one
/// thread takes at a time.
constexpr std::size_t kManyPairs = 256, kPairsOfLayer = 24, kPairsOfWork = 8;

/// v += x a + y b + z c. @param x  followed by y and z, n of each
BRIM_WIDE void add_run(const double* __restrict x, std::size_t n, double a, double b, double c, double* __restrict v) {
  const double *y = x + n, *z = y + n;
  for (std::size_t i = 0; i < n; ++i) v[i] += x[i] * a + y[i] * b + z[i] * c;
}

}  // namespace

void ProjectedGaussSeidel::clear() {
  place_.clear(), group_.clear(), pairs_.clear();
  shares_.clear(), runs_.clear(), response_.clear();
  friction_.clear(), local_.clear(), local_inverse_.clear();
  first_share_.assign(1, 0), first_run_.assign(1, 0);
  learned_.clear(), learned_columns_ = 0;
}

void ProjectedGaussSeidel::add(std::span<const Entry> entries, double friction) {
  Mat3 W = Mat3::Zero();
  for (const Entry& e : entries) W += e.row * e.response.transpose();
  group_.push_back({size(), size() + 1, false, friction_.size()});
  place_.push_back({false, friction_.size()});
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const Entry& e = entries[i];
    if (e.row != Vec3::Zero()) shares_.push_back({e.index, e.row});
    if (i == 0 || e.index != entries[i - 1].index + 1) runs_.push_back({e.index, 0, 0});
    ++runs_.back().size;
  }
  std::size_t i = 0;
  for (std::size_t k = first_run_.back(); k < runs_.size(); ++k) {
    Run& run = runs_[k];
    run.begin = response_.size();
    for (int axis = 0; axis < 3; ++axis)
      for (std::size_t j = i; j < i + run.size; ++j) response_.push_back(entries[j].response[axis]);
    i += run.size;
  }
  first_share_.push_back(shares_.size()), first_run_.push_back(runs_.size());
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
  for (std::size_t i = first_share_[r]; i < first_share_[r + 1]; ++i) u += shares_[i].row * v[shares_[i].index];
  const Vec3* column = learned_.data() + r * kLearned;
  for (std::size_t k = 0; k < learned_columns_; ++k) u += column[k] * v[first_learned_[r] + k];
  return u;
}

void ProjectedGaussSeidel::add_row_response(std::size_t r, const Vec3& impulse, std::span<double> v) const {
  for (std::size_t k = first_run_[r]; k < first_run_[r + 1]; ++k)
    add_run(response_.data() + runs_[k].begin, runs_[k].size, impulse.x(), impulse.y(), impulse.z(),
            v.data() + runs_[k].index);
  const Vec3* column = learned_.data() + r * kLearned;
  for (std::size_t k = 0; k < learned_columns_; k += 2) {
    v[first_learned_[r] + k] -= column[k].dot(impulse);
    v[first_learned_[r] + k + 1] += column[k + 1].dot(impulse);
  }
}

void ProjectedGaussSeidel::begin_learning(std::size_t first, std::span<const std::int32_t> island) {
  island_.assign(island.begin(), island.end());
  island_.resize(size(), 0);
  learned_columns_ = 0;
  learned_.assign(friction_.size() * kLearned, Vec3::Zero());
  first_learned_.assign(friction_.size(), first);
  for (std::size_t c = 0; c < size(); ++c)
    if (!place_[c].rigid) first_learned_[place_[c].row] += kLearned * static_cast<std::size_t>(island_[c]);
}

void ProjectedGaussSeidel::learn(std::span<const Vec3> impulse, std::span<const Vec3> expected,
                                 std::span<const Vec3> actual) {
  if (learned_columns_ == kLearned || size() == 0) return;
  const auto islands = static_cast<std::size_t>(*std::ranges::max_element(island_)) + 1;
  std::vector<double> before(islands, 0.0), after(islands, 0.0);
  for (std::size_t c = 0; c < size(); ++c) {
    const auto i = static_cast<std::size_t>(island_[c]);
    before[i] += impulse[c].dot(expected[c]), after[i] += impulse[c].dot(actual[c]);
  }
  bool any = false;
  for (std::size_t c = 0; c < size(); ++c) {
    const auto i = static_cast<std::size_t>(island_[c]);
    if (place_[c].rigid || !(before[i] > 0.0) || !(after[i] > 0.0)) continue;
    any = true;
    const std::size_t r = place_[c].row;
    Vec3* column = learned_.data() + r * kLearned + learned_columns_;
    column[0] = expected[c] / std::sqrt(before[i]), column[1] = actual[c] / std::sqrt(after[i]);
    local_[r] += column[1] * column[1].transpose() - column[0] * column[0].transpose();
    local_inverse_[r] = invert_response(local_[r]);
  }
  if (any) learned_columns_ += 2;
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
  for (std::size_t i = first_share_[p.row]; i < first_share_[p.row + 1]; ++i)
    if (shares_[i].index < Q.size()) Q[shares_[i].index] += shares_[i].row.dot(impulse);
}

double ProjectedGaussSeidel::relax(std::size_t r, double friction, const Vec3& offset, double target, Vec3& impulse,
                                   std::span<double> v) const {
  const Mat3& W = local_[r];
  if (!(W(0, 0) > 0.0)) return 0.0;
  Vec3 u = row_velocity(r, v) + offset;
  u.x() -= target;
  const Vec3 next = solve_contact(W, local_inverse_[r], friction * friction_[r], u, impulse), change = next - impulse;
  impulse = next;
  add_row_response(r, change, v);
  return (W * change).cwiseAbs().maxCoeff();
}

double ProjectedGaussSeidel::relax_group(const Group& g, bool backward, double friction, std::span<const Vec3> offset,
                                         std::span<const double> target, std::span<Vec3> impulse,
                                         std::span<double> v) const {
  const std::size_t n = g.end - g.begin;
  return g.rigid ? pairs_.relax(g.index, backward, kRounds, friction, offset.subspan(g.begin, n),
                                target.subspan(g.begin, n), impulse.subspan(g.begin, n), v)
                 : relax(g.index, friction, offset[g.begin], target[g.begin], impulse[g.begin], v);
}

void ProjectedGaussSeidel::find_layers(std::size_t width) {
  layer_first_.clear();
  if (!friction_.empty() || group_.size() < kManyPairs || thread_count() == 1) return;
  std::vector<std::uint32_t> layer(group_.size()), after(width, 0);  // after: the layer past the last one of a body
  std::uint32_t layers = 0;
  for (std::size_t g = 0; g < group_.size(); ++g) {
    const auto [a, b] = pairs_.bodies(group_[g].index);
    for (const std::size_t body : {a, b})
      if (body != RigidPairRows::kFixed) layer[g] = std::max(layer[g], after[body]);
    for (const std::size_t body : {a, b})
      if (body != RigidPairRows::kFixed) after[body] = layer[g] + 1;
    layers = std::max(layers, layer[g] + 1);
  }
  if (group_.size() < kPairsOfLayer * layers) return;
  layer_first_.assign(layers + 1, 0);
  for (const std::uint32_t l : layer) ++layer_first_[l + 1];
  for (std::uint32_t l = 0; l < layers; ++l) layer_first_[l + 1] += layer_first_[l];
  std::vector<std::size_t> next(layer_first_.begin(), layer_first_.end() - 1);
  layered_.resize(group_.size()), change_.resize(group_.size());
  for (std::size_t g = 0; g < group_.size(); ++g) layered_[next[layer[g]]++] = static_cast<std::uint32_t>(g);
}

double ProjectedGaussSeidel::sweep(bool backward, const SweepOptions& options, std::span<const Vec3> offset,
                                   std::span<const double> target, std::span<Vec3> impulse, std::span<double> v) const {
  double worst = 0.0;
  if (layer_first_.empty()) {
    for (std::size_t k = 0; k < group_.size(); ++k) {
      const Group& group = group_[backward ? group_.size() - 1 - k : k];
      if (!options.skipped.empty() && options.skipped[group.begin]) continue;
      worst = std::max(worst, relax_group(group, backward, options.friction, offset, target, impulse, v));
    }
    return worst;
  }
  const std::size_t layers = layer_first_.size() - 1;
  for (std::size_t k = 0; k < layers; ++k) {
    const std::size_t l = backward ? layers - 1 - k : k;
    parallel_for(
        layer_first_[l + 1] - layer_first_[l],
        [&](std::size_t i) {
          const std::uint32_t g = layered_[layer_first_[l] + i];
          change_[g] = relax_group(group_[g], backward, options.friction, offset, target, impulse, v);
        },
        kPairsOfWork);
  }
  for (const double change : change_) worst = std::max(worst, change);
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
                                                         SweepOptions options, std::span<Vec3> impulse,
                                                         std::span<double> v) {
  Report report;
  const std::size_t n = size();
  for (std::size_t c = 0; c < n; ++c) {
    if (!options.skipped.empty() && options.skipped[c]) continue;
    const Vec3 u = velocity(c, v) + offset[c];
    if (u.x() < target[c] || impulse[c].x() > 0.0) options.scale = std::max(options.scale, std::abs(u.x() - target[c]));
  }
  if (n == 0 || !(options.scale > 0.0)) return report;
  const bool at_once = options.may_at_once && n <= kMostAtOnce, rigid = pairs_only();
  SweepOptions first = options;
  if (at_once && !rigid) first.max_sweeps = std::min(options.max_sweeps, kFewSweeps);
  report = sweeps(offset, target, first, impulse, v);
  if (at_once && !report.converged && (!rigid || report.residual > kFarOff * options.tolerance)) {
    options.max_sweeps -= report.sweeps;
    solve_at_once(offset, target, options, impulse, v, report);
  }
  report.scale = options.scale;
  return report;
}

ProjectedGaussSeidel::Report ProjectedGaussSeidel::sweeps(std::span<const Vec3> offset, std::span<const double> target,
                                                          const SweepOptions& options, std::span<Vec3> impulse,
                                                          std::span<double> v) {
  Report report;
  const std::size_t n = size();
  report.converged = false;
  find_layers(v.size());
  // A forward and a backward sweep are one step; between steps the last directions are followed further.
  way_.assign(n, Vec3::Zero());
  v_way_.assign(v.size(), 0.0);
  double last = 0.0;
  while (report.sweeps < options.max_sweeps) {
    check_stop();
    before_.assign(impulse.begin(), impulse.end());
    v_before_.assign(v.begin(), v.end());
    double worst = sweep(false, options, offset, target, impulse, v);
    worst = std::max(worst, sweep(true, options, offset, target, impulse, v));
    report.sweeps += 2;
    report.residual = worst / options.scale;
    report.converged = report.residual <= options.tolerance;
    if (report.converged || report.sweeps >= options.max_sweeps) break;
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
