#include "brim/world/substeps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "brim/body/motion_clusters.h"
#include "brim/body/posed_shape.h"
#include "brim/body/solid_of.h"
#include "brim/body/spinning_balls.h"
#include "brim/core/interface_of.h"
#include "brim/core/parallel.h"
#include "brim/world/contact_parameters.h"

namespace brim {

namespace {

/// Share of the combined thickness of two parts that they may move in one sub-step.
constexpr double kShareOfThickness = 0.25;
/// [voxels] assumed for a part of unknown thickness: voxels are chosen so that two fit.
constexpr double kLeastThickness = 2.0;

/// [radii] by which a ball may fall in one sub-step. Heaps of 588 balls of 10 mm move at 1.0 to 8.8 mm/s (root mean
/// square) after 3 s at 0.27, and at 0.3 to 1.3 mm/s at 0.07 (heap_rests of docs/validation.md).
constexpr double kFallOfBalls = 0.16;

/// The speeds of the two fastest parts, [m/s]: their sum bounds every relative speed.
class FastestTwo {
 public:
  void add(double speed) {
    second_ = std::max(second_, std::min(first_, speed));
    first_ = std::max(first_, speed);
  }
  double sum() const { return first_ + second_; }

 private:
  double first_ = 0.0, second_ = 0.0;
};

/// An upper bound of the pieces without looking at pairs: the two fastest parts at the finest step.
double most_pieces(const FastestTwo& speeds, std::span<const WorldPart> parts, const WorldOptions& options,
                   double time) {
  double h = std::numeric_limits<double>::infinity();
  for (const WorldPart& part : parts) h = std::min(h, part.h);
  return speeds.sum() * time / (options.max_motion_voxels * h);
}

/// The same before parts are divided into clusters; infinite when a part has clusters.
double most_pieces_of_whole(std::span<const WorldPart> parts, std::span<const double> v,
                            std::span<const std::size_t> first_v, const WorldOptions& options, double time,
                            double change) {
  FastestTwo speeds;
  for (const WorldPart& part : parts) {
    if (interface_of<MotionClusters>(*part.body) != nullptr) return std::numeric_limits<double>::infinity();
    speeds.add(speed_bound(part, velocities_of(part, v, first_v)) + (is_fixed(part) ? 0.0 : change));
  }
  return most_pieces(speeds, parts, options, time);
}

/// @param first  first cluster of each part, and the end
double most_pieces_of_clusters(std::span<const MotionCluster> clusters, std::span<const std::size_t> first,
                               std::span<const WorldPart> parts, const WorldOptions& options, double time) {
  FastestTwo speeds;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    double most = 0.0;
    for (const MotionCluster& c : clusters.subspan(first[p], first[p + 1] - first[p]))
      most = std::max(most, c.velocity.lo.cwiseAbs().cwiseMax(c.velocity.hi.cwiseAbs()).norm() + c.deviation);
    speeds.add(most);
  }
  return most_pieces(speeds, parts, options, time);
}

/// Clusters per piece of work, and pairs of them.
constexpr std::size_t kEntriesOfWork = 64, kPairsOfWork = 64;
/// Parts per piece of work when each is one cluster.
constexpr std::size_t kPartsOfWork = 64;

/// World normal of a part that is a half-space and does not turn; zero for all other parts.
Vec3 normal_of_half_space(const WorldPart& part, std::span<const double> v) {
  const PosedShape* solid = part.body->immobile() ? solid_of(*part.body, part.index) : nullptr;
  if (solid == nullptr || v.size() != 6 || !solid->shape().half_space()) return Vec3::Zero();
  if (v[3] != 0.0 || v[4] != 0.0 || v[5] != 0.0) return Vec3::Zero();
  return solid->pose().rotation.col(2);
}

struct FastPair {
  double bound;      ///< upper bound of pieces
  double per_speed;  ///< [s/m] pieces for a relative speed
  std::int32_t a, b;
};

}  // namespace

double motion_limit(const WorldPart& a, const WorldPart& b, const WorldOptions& options, bool held) {
  const double h = meeting_step(a, b);
  const double usual = options.max_motion_voxels * h;
  if ((held && meet_by_rigid_rows(a, b, options)) || a.info.conforming || b.info.conforming) return usual;
  const auto thickness = [](const WorldPart& p) {
    return std::isfinite(p.info.thickness) ? p.info.thickness : kLeastThickness * p.h;
  };
  return std::clamp(kShareOfThickness * (thickness(a) + thickness(b)), usual,
                    std::max(usual, std::min(2.0 * usual, 2.0 * h)));
}

double motion_pieces(std::span<const WorldPart> parts, std::span<const double> v, std::span<const std::size_t> first_v,
                     const WorldOptions& options, double time, double change, const HeldPairs& held, BoxSweep& sweep,
                     AlongPlanes along) {
  if (most_pieces_of_whole(parts, v, first_v, options, time, change) <= 1.0) return 1.0;
  const double wide = std::ldexp(0.5 * options.ramp_voxels, coarsest_level(parts));
  const auto velocities = [&](const WorldPart& part) { return velocities_of(part, v, first_v); };
  // Clusters of the parts that have several; every other part is one.
  std::vector<std::vector<MotionCluster>> several;
  std::vector<std::int32_t> number(parts.size(), -1), cut;
  for (std::size_t p = 0; p < parts.size(); ++p)
    if (interface_of<MotionClusters>(*parts[p].body) != nullptr)
      number[p] = static_cast<std::int32_t>(cut.size()), cut.push_back(static_cast<std::int32_t>(p));
  several.resize(cut.size());
  parallel_for(cut.size(), [&](std::size_t k) {
    const WorldPart& part = parts[cut[k]];
    interface_of<MotionClusters>(*part.body)->motion_clusters(part.index, velocities(part), several[k]);
  });
  const auto whole = [&](std::size_t p) { return number[p] < 0 || several[number[p]].empty(); };
  std::vector<Vec3> normal(parts.size(), Vec3::Zero());
  for (std::size_t p = 0; p < parts.size() && along == AlongPlanes::Ignored; ++p)
    normal[p] = normal_of_half_space(parts[p], velocities(parts[p]));
  const auto speed_between = [&](const MotionCluster& a, const MotionCluster& b, std::int32_t part_a,
                                 std::int32_t part_b) {
    for (const std::int32_t p : {part_a, part_b})
      if (!normal[p].isZero(0.0)) return relative_speed(a, b, normal[p]);
    return relative_speed(a, b);
  };
  std::vector<std::size_t> first(parts.size() + 1, 0);
  for (std::size_t p = 0; p < parts.size(); ++p) first[p + 1] = first[p] + (whole(p) ? 1 : several[number[p]].size());
  std::vector<MotionCluster> clusters(first.back());
  std::vector<Aabb> boxes(first.back());
  std::vector<std::int32_t> part(first.back()), group(first.back());
  parallel_for(
      parts.size(),
      [&](std::size_t p) {
        const WorldPart& own = parts[p];
        const bool by_itself = !whole(p) && interface_of<MotionClusters>(*own.body)->meets_itself();
        if (whole(p)) {
          const auto vb = velocities(own);
          const Vec3 mean = own.body->mean_velocity(own.index, vb);
          clusters[first[p]] = {
              own.body->bounds(own.index), {mean, mean}, own.body->relative_speed_bound(own.index, vb)};
        } else {
          std::copy(several[number[p]].begin(), several[number[p]].end(),
                    clusters.begin() + static_cast<std::ptrdiff_t>(first[p]));
        }
        for (std::size_t k = first[p]; k < first[p + 1]; ++k) {
          MotionCluster& c = clusters[k];
          if (!is_fixed(own)) c.deviation += change;
          const Aabb now = c.box.inflated(wide * own.h + c.deviation * time);
          boxes[k] = now;
          boxes[k].extend(Aabb{now.lo + time * c.velocity.lo, now.hi + time * c.velocity.hi});
          part[k] = static_cast<std::int32_t>(p);
          // Members of a group are not tested against each other; parts are numbered from 0 on.
          group[k] = by_itself ? -1 - static_cast<std::int32_t>(k) : part[k];
        }
      },
      kPartsOfWork);
  if (most_pieces_of_clusters(clusters, first, parts, options, time) <= 1.0) return 1.0;
  sweep.build(boxes, group);
  // Pairs of clusters that need more than one piece, by loose bounds.
  std::vector<std::vector<FastPair>> fast_of((boxes.size() + kEntriesOfWork - 1) / kEntriesOfWork);
  parallel_blocks(boxes.size(), kEntriesOfWork, [&](std::size_t begin, std::size_t end) {
    std::vector<FastPair>& fast = fast_of[begin / kEntriesOfWork];
    std::vector<std::int32_t> partners;
    std::int32_t last_a = -1, last_b = -1;  // consecutive entries often belong to the same two parts
    double per_speed = 0.0;                 // [s/m]
    for (std::size_t i = begin; i < end; ++i) {
      const std::int32_t own = sweep.at(i);
      partners.clear();
      sweep.partners(i, partners);
      for (const std::int32_t j : partners) {
        if (part[own] != last_a || part[j] != last_b) {
          last_a = part[own], last_b = part[j];
          const WorldPart &a = parts[last_a], &b = parts[last_b];
          per_speed = last_a == last_b || may_touch(a, b)
                          ? time / motion_limit(a, b, options, held.contains(last_a, last_b))
                          : 0.0;
        }
        const double pieces =
            per_speed > 0.0 ? speed_between(clusters[own], clusters[j], part[own], part[j]) * per_speed : 0.0;
        if (pieces > 1.0) fast.push_back({pieces, per_speed, own, j});
      }
    }
  });
  std::vector<FastPair> fast;
  for (const auto& f : fast_of) fast.insert(fast.end(), f.begin(), f.end());
  if (fast.empty()) return 1.0;

  // They are refined by finer clusters: those with the largest bounds first, until no bound exceeds the result so far.
  std::vector<std::uint8_t> wanted(clusters.size(), 0);
  for (const FastPair& f : fast) wanted[f.a] = wanted[f.b] = 1;
  std::vector<std::vector<MotionCluster>> finer(clusters.size());  // itself if it has none
  parallel_for(
      clusters.size(),
      [&](std::size_t k) {
        if (!wanted[k]) return;
        const auto own = static_cast<std::size_t>(part[k]);
        const WorldPart& p = parts[own];
        if (!whole(own))
          interface_of<MotionClusters>(*p.body)->finer_clusters(p.index, k - first[own], velocities(p), finer[k]);
        for (MotionCluster& fine : finer[k])
          if (!is_fixed(p)) fine.deviation += change;
        if (finer[k].empty()) finer[k].push_back(clusters[k]);
      },
      16);
  std::sort(fast.begin(), fast.end(), [](const FastPair& x, const FastPair& y) {
    return std::tie(y.bound, x.a, x.b) < std::tie(x.bound, y.a, y.b);
  });
  const auto closer = [&](std::span<const FastPair> pairs, double pieces) {
    for (const FastPair& f : pairs) {
      if (f.bound <= pieces) break;
      const double reach = wide * (parts[part[f.a]].h + parts[part[f.b]].h);
      for (const MotionCluster& a : finer[f.a])
        for (const MotionCluster& b : finer[f.b])
          if (const double n = speed_between(a, b, part[f.a], part[f.b]) * f.per_speed;
              n > pieces && may_meet(a, b, reach, time))
            pieces = n;
    }
    return pieces;
  };
  const std::size_t some = std::min(fast.size(), kPairsOfWork);
  const double found = closer(std::span(fast).first(some), 1.0);
  const auto rest = std::span(fast).subspan(some);
  std::vector<double> most_of((rest.size() + kPairsOfWork - 1) / kPairsOfWork, found);
  parallel_blocks(rest.size(), kPairsOfWork, [&](std::size_t begin, std::size_t end) {
    most_of[begin / kPairsOfWork] = closer(rest.subspan(begin, end - begin), found);
  });
  return std::max(found, most_of.empty() ? 1.0 : *std::max_element(most_of.begin(), most_of.end()));
}

double thrown_pieces(std::span<const WorldPart> parts, std::span<const double> change,
                     std::span<const std::size_t> first_v, const WorldOptions& options, double time,
                     const HeldPairs& held, BoxSweep& sweep) {
  const auto own = [&](const WorldPart& part) { return velocities_of(part, change, first_v); };
  if (std::ranges::all_of(parts, [&](const WorldPart& p) { return normal_of_half_space(p, own(p)).isZero(0.0); }))
    return 1.0;
  FastestTwo speeds;
  for (const WorldPart& part : parts) speeds.add(speed_bound(part, own(part)));
  if (most_pieces(speeds, parts, options, time) <= 1.0) return 1.0;
  return motion_pieces(parts, change, first_v, options, time, 0.0, held, sweep, AlongPlanes::Counted);
}

double fall_pieces(std::span<const WorldPart> parts, double gravity, double time) {
  double radius = std::numeric_limits<double>::infinity();
  for (const WorldPart& part : parts)
    if (const auto* balls = interface_of<SpinningBalls>(*part.body)) radius = std::min(radius, balls->least_radius());
  return std::max(1.0, time * std::sqrt(gravity / (kFallOfBalls * radius)));
}

double choose_substep(double pieces, const WorldOptions& options, double left, StepReport& report) {
  const double remaining = std::max(1, options.max_substeps - report.substeps);
  double n = std::ceil(pieces - 1e-9);
  if (report.substeps == 0) n = std::max(n, static_cast<double>(options.min_substeps));
  if (n > remaining) {
    n = remaining;
    if (report.warnings.empty() || report.warnings.back().code != "substeps_capped")
      report.warnings.push_back(
          {report.time, "substeps_capped",
           fmt::format("relative motion asks for {} sub-steps, and {} of the {} that max_substeps allows are left; "
                       "bodies may pass through each other",
                       pieces < 1e9 ? fmt::format("{:.0f}", std::ceil(pieces)) : "too many", remaining,
                       options.max_substeps)});
  }
  return left / n;
}

}  // namespace brim
