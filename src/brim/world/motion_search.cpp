#include "brim/world/motion_search.h"

#include <cmath>
#include <limits>
#include <tuple>

#include "brim/body/posed_shape.h"
#include "brim/body/solid_of.h"
#include "brim/core/interface_of.h"
#include "brim/core/parallel.h"

namespace brim {

namespace {

/// Clusters per piece of work, and pairs of them.
constexpr std::size_t kEntriesOfWork = 64, kPairsOfWork = 64;
/// Parts per piece of work when each is one cluster.
constexpr std::size_t kPartsOfWork = 64;
/// Clusters per piece of work when they are divided.
constexpr std::size_t kClustersOfWork = 16;

}  // namespace

double most_pieces(const FastestTwo& speeds, std::span<const WorldPart> parts, const WorldOptions& options,
                   double time) {
  double h = std::numeric_limits<double>::infinity();
  for (const WorldPart& part : parts) h = std::min(h, part.h);
  return speeds.sum() * time / (options.max_motion_voxels * h);
}

Vec3 normal_of_half_space(const WorldPart& part, std::span<const double> v) {
  const PosedShape* solid = part.body->immobile() ? solid_of(*part.body, part.index) : nullptr;
  if (solid == nullptr || v.size() != 6 || !solid->shape().half_space()) return Vec3::Zero();
  if (v[3] != 0.0 || v[4] != 0.0 || v[5] != 0.0) return Vec3::Zero();
  return solid->pose().rotation.col(2);
}

MotionSearch::MotionSearch(const PartMotion& motion, BoxSweep& sweep)
    : motion_(motion),
      sweep_(sweep),
      wide_(std::ldexp(0.5 * motion.options.ramp_voxels, coarsest_level(motion.parts))) {}

double MotionSearch::pieces() {
  if (most_pieces_of_whole() <= 1.0) return 1.0;
  find_clusters();
  place_clusters();
  if (most_pieces_of_clusters() <= 1.0) return 1.0;
  find_fast_pairs();
  if (fast_.empty()) return 1.0;
  refine_clusters();
  return largest();
}

double MotionSearch::most_pieces_of_whole() const {
  FastestTwo speeds;
  for (const WorldPart& part : motion_.parts) {
    if (interface_of<MotionClusters>(*part.body) != nullptr) return std::numeric_limits<double>::infinity();
    speeds.add(speed_bound(part, velocities(part)) + (is_fixed(part) ? 0.0 : motion_.change));
  }
  return most_pieces(speeds, motion_.parts, motion_.options, motion_.time);
}

double MotionSearch::most_pieces_of_clusters() const {
  FastestTwo speeds;
  for (std::size_t p = 0; p < motion_.parts.size(); ++p) {
    double most = 0.0;
    for (const MotionCluster& c : std::span(clusters_).subspan(first_[p], first_[p + 1] - first_[p]))
      most = std::max(most, c.velocity.lo.cwiseAbs().cwiseMax(c.velocity.hi.cwiseAbs()).norm() + c.deviation);
    speeds.add(most);
  }
  return most_pieces(speeds, motion_.parts, motion_.options, motion_.time);
}

void MotionSearch::find_clusters() {
  const std::span<const WorldPart> parts = motion_.parts;
  std::vector<std::int32_t> cut;
  number_.assign(parts.size(), -1);
  for (std::size_t p = 0; p < parts.size(); ++p)
    if (interface_of<MotionClusters>(*parts[p].body) != nullptr)
      number_[p] = static_cast<std::int32_t>(cut.size()), cut.push_back(static_cast<std::int32_t>(p));
  several_.resize(cut.size());
  parallel_for(cut.size(), [&](std::size_t k) {
    const WorldPart& part = parts[cut[k]];
    interface_of<MotionClusters>(*part.body)->motion_clusters(part.index, velocities(part), several_[k]);
  });
}

void MotionSearch::place_clusters() {
  const std::span<const WorldPart> parts = motion_.parts;
  normal_.assign(parts.size(), Vec3::Zero());
  for (std::size_t p = 0; p < parts.size() && motion_.along == AlongPlanes::Ignored; ++p)
    normal_[p] = normal_of_half_space(parts[p], velocities(parts[p]));
  first_.assign(parts.size() + 1, 0);
  for (std::size_t p = 0; p < parts.size(); ++p)
    first_[p + 1] = first_[p] + (whole(p) ? 1 : several_[number_[p]].size());
  clusters_.resize(first_.back());
  boxes_.resize(first_.back());
  part_.resize(first_.back());
  group_.resize(first_.back());
  parallel_for(
      parts.size(), [&](std::size_t p) { place_clusters_of(p); }, kPartsOfWork);
}

void MotionSearch::place_clusters_of(std::size_t p) {
  const WorldPart& own = motion_.parts[p];
  const double time = motion_.time;
  const bool by_itself = !whole(p) && interface_of<MotionClusters>(*own.body)->meets_itself();
  if (whole(p)) {
    const auto vb = velocities(own);
    const Vec3 mean = own.body->mean_velocity(own.index, vb);
    clusters_[first_[p]] = {own.body->bounds(own.index), {mean, mean}, own.body->relative_speed_bound(own.index, vb)};
  } else {
    std::copy(several_[number_[p]].begin(), several_[number_[p]].end(),
              clusters_.begin() + static_cast<std::ptrdiff_t>(first_[p]));
  }
  for (std::size_t k = first_[p]; k < first_[p + 1]; ++k) {
    MotionCluster& c = clusters_[k];
    if (!is_fixed(own)) c.deviation += motion_.change;
    const Aabb now = c.box.inflated(wide_ * own.h + c.deviation * time);
    boxes_[k] = now;
    boxes_[k].extend(Aabb{now.lo + time * c.velocity.lo, now.hi + time * c.velocity.hi});
    part_[k] = static_cast<std::int32_t>(p);
    // Members of a group are not tested against each other; parts are numbered from 0 on.
    group_[k] = by_itself ? -1 - static_cast<std::int32_t>(k) : part_[k];
  }
}

void MotionSearch::find_fast_pairs() {
  sweep_.build(boxes_, group_);
  std::vector<std::vector<FastPair>> fast_of((boxes_.size() + kEntriesOfWork - 1) / kEntriesOfWork);
  parallel_blocks(boxes_.size(), kEntriesOfWork, [&](std::size_t begin, std::size_t end) {
    find_fast_pairs_of(begin, end, fast_of[begin / kEntriesOfWork]);
  });
  for (const auto& f : fast_of) fast_.insert(fast_.end(), f.begin(), f.end());
}

void MotionSearch::find_fast_pairs_of(std::size_t begin, std::size_t end, std::vector<FastPair>& fast) const {
  std::vector<std::int32_t> partners;
  std::int32_t last_a = -1, last_b = -1;  // consecutive entries often belong to the same two parts
  double per_speed = 0.0;
  for (std::size_t i = begin; i < end; ++i) {
    const std::int32_t own = sweep_.at(i);
    partners.clear();
    sweep_.partners(i, partners);
    for (const std::int32_t j : partners) {
      if (part_[own] != last_a || part_[j] != last_b) {
        last_a = part_[own], last_b = part_[j];
        per_speed = pieces_per_speed(last_a, last_b);
      }
      const double pieces =
          per_speed > 0.0 ? speed_between(clusters_[own], clusters_[j], part_[own], part_[j]) * per_speed : 0.0;
      if (pieces > 1.0) fast.push_back({pieces, per_speed, own, j});
    }
  }
}

double MotionSearch::pieces_per_speed(std::int32_t part_a, std::int32_t part_b) const {
  const WorldPart &a = motion_.parts[part_a], &b = motion_.parts[part_b];
  if (part_a != part_b && !may_touch(a, b)) return 0.0;
  return motion_.time / motion_limit(a, b, motion_.options, motion_.held.contains(part_a, part_b));
}

void MotionSearch::refine_clusters() {
  std::vector<std::uint8_t> wanted(clusters_.size(), 0);
  for (const FastPair& f : fast_) wanted[f.a] = wanted[f.b] = 1;
  finer_.resize(clusters_.size());
  parallel_for(
      clusters_.size(),
      [&](std::size_t k) {
        if (!wanted[k]) return;
        const auto own = static_cast<std::size_t>(part_[k]);
        const WorldPart& p = motion_.parts[own];
        if (!whole(own))
          interface_of<MotionClusters>(*p.body)->finer_clusters(p.index, k - first_[own], velocities(p), finer_[k]);
        for (MotionCluster& fine : finer_[k])
          if (!is_fixed(p)) fine.deviation += motion_.change;
        if (finer_[k].empty()) finer_[k].push_back(clusters_[k]);
      },
      kClustersOfWork);
}

double MotionSearch::largest() {
  std::sort(fast_.begin(), fast_.end(), [](const FastPair& x, const FastPair& y) {
    return std::tie(y.bound, x.a, x.b) < std::tie(x.bound, y.a, y.b);
  });
  // The first few alone: what they need leaves little to do for the rest.
  const std::size_t some = std::min(fast_.size(), kPairsOfWork);
  const double found = largest_of(std::span(fast_).first(some), 1.0);
  const auto rest = std::span(fast_).subspan(some);
  std::vector<double> most_of((rest.size() + kPairsOfWork - 1) / kPairsOfWork, found);
  parallel_blocks(rest.size(), kPairsOfWork, [&](std::size_t begin, std::size_t end) {
    most_of[begin / kPairsOfWork] = largest_of(rest.subspan(begin, end - begin), found);
  });
  return std::max(found, most_of.empty() ? 1.0 : *std::max_element(most_of.begin(), most_of.end()));
}

double MotionSearch::largest_of(std::span<const FastPair> pairs, double pieces) const {
  for (const FastPair& f : pairs) {
    if (f.bound <= pieces) break;
    const double reach = wide_ * (motion_.parts[part_[f.a]].h + motion_.parts[part_[f.b]].h);
    for (const MotionCluster& a : finer_[f.a])
      for (const MotionCluster& b : finer_[f.b])
        if (const double n = speed_between(a, b, part_[f.a], part_[f.b]) * f.per_speed;
            n > pieces && may_meet(a, b, reach, motion_.time))
          pieces = n;
  }
  return pieces;
}

double MotionSearch::speed_between(const MotionCluster& a, const MotionCluster& b, std::int32_t part_a,
                                   std::int32_t part_b) const {
  for (const std::int32_t p : {part_a, part_b})
    if (!normal_[p].isZero(0.0)) return relative_speed(a, b, normal_[p]);
  return relative_speed(a, b);
}

}  // namespace brim
