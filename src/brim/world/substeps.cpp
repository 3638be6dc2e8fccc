#include "brim/world/substeps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "brim/body/motion_clusters.h"
#include "brim/core/parallel.h"
#include "brim/math/box_sweep.h"
#include "brim/world/pair_laws.h"

namespace brim {

namespace {

/// Share of the thickness of two parts together by which they may move in one sub-step.
constexpr double kShareOfThickness = 0.25;
/// [voxels] of a part whose thickness is not known: voxels are chosen so that two fit.
constexpr double kLeastThickness = 2.0;

/// An upper bound of the pieces without looking at pairs: those of the two fastest parts, met at the finest step.
/// Infinite where a part is looked at in clusters.
double most_pieces(std::span<const WorldPart> parts, std::span<const double> v, std::span<const std::size_t> first_v,
                   const WorldOptions& options, double time, double change) {
  double fastest = 0.0, second = 0.0, h = std::numeric_limits<double>::infinity();
  for (const WorldPart& part : parts) {
    if (dynamic_cast<const MotionClusters*>(part.body) != nullptr) return std::numeric_limits<double>::infinity();
    const auto vb = v.subspan(first_v[part.body_index], first_v[part.body_index + 1] - first_v[part.body_index]);
    const double speed = part.body->carrier_velocity(part.index, vb).norm() +
                         part.body->relative_speed_bound(part.index, vb) + (is_fixed(part) ? 0.0 : change);
    second = std::max(second, std::min(fastest, speed));
    fastest = std::max(fastest, speed);
    h = std::min(h, part.h);
  }
  return (fastest + second) * time / (options.max_motion_voxels * h);
}

/// Clusters of one piece of work.
constexpr std::size_t kEntriesOfWork = 256;

}  // namespace

double motion_limit(const WorldPart& a, const WorldPart& b, const WorldOptions& options) {
  const double h = meeting_step(a, b);
  const double usual = options.max_motion_voxels * h;
  if (meet_by_rigid_rows(a, b, options) || a.info.shapeless || b.info.shapeless) return usual;
  const auto thickness = [](const WorldPart& p) {
    return std::isfinite(p.info.thickness) ? p.info.thickness : kLeastThickness * p.h;
  };
  return std::clamp(kShareOfThickness * (thickness(a) + thickness(b)), usual,
                    std::max(usual, std::min(2.0 * usual, 2.0 * h)));
}

double motion_pieces(std::span<const WorldPart> parts, std::span<const double> v, std::span<const std::size_t> first_v,
                     const WorldOptions& options, double time, double change) {
  if (most_pieces(parts, v, first_v, options, time, change) <= 1.0) return 1.0;
  std::vector<std::vector<MotionCluster>> clusters(parts.size());
  std::vector<std::vector<Aabb>> swept(parts.size());
  const double wide = std::ldexp(0.5 * options.ramp_voxels, coarsest_level(parts));
  parallel_for(parts.size(), [&](std::size_t p) {
    const WorldPart& part = parts[p];
    const auto vb = v.subspan(first_v[part.body_index], first_v[part.body_index + 1] - first_v[part.body_index]);
    if (const auto* moving = dynamic_cast<const MotionClusters*>(part.body))
      moving->motion_clusters(part.index, vb, clusters[p]);
    if (clusters[p].empty()) {
      const Vec3 mean = part.body->carrier_velocity(part.index, vb);
      clusters[p].push_back(
          {part.body->bounds(part.index), {mean, mean}, part.body->relative_speed_bound(part.index, vb)});
    }
    for (MotionCluster& c : clusters[p]) {
      if (!is_fixed(part)) c.deviation += change;
      const Aabb now = c.box.inflated(wide * part.h + c.deviation * time);
      Aabb box = now;
      box.extend(Aabb{now.lo + time * c.velocity.lo, now.hi + time * c.velocity.hi});
      swept[p].push_back(box);
    }
  });
  std::vector<Aabb> boxes;
  std::vector<const MotionCluster*> motion;
  std::vector<std::int32_t> part;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    boxes.insert(boxes.end(), swept[p].begin(), swept[p].end());
    for (const MotionCluster& c : clusters[p]) motion.push_back(&c);
    part.resize(boxes.size(), static_cast<std::int32_t>(p));
  }
  BoxSweep sweep;
  sweep.build(boxes, part);
  std::vector<double> most_of((boxes.size() + kEntriesOfWork - 1) / kEntriesOfWork, 1.0);
  parallel_blocks(boxes.size(), kEntriesOfWork, [&](std::size_t begin, std::size_t end) {
    double& pieces = most_of[begin / kEntriesOfWork];
    std::vector<std::int32_t> partners;
    std::int32_t last_a = -1, last_b = -1;  // neighbours in the order are often of the same two parts
    double per_speed = 0.0;                 // [s/m]
    for (std::size_t i = begin; i < end; ++i) {
      const std::int32_t own = sweep.at(i);
      partners.clear();
      sweep.partners(i, partners);
      for (const std::int32_t j : partners) {
        if (part[own] != last_a || part[j] != last_b) {
          last_a = part[own], last_b = part[j];
          const WorldPart &a = parts[last_a], &b = parts[last_b];
          per_speed = may_touch(a, b) ? time / motion_limit(a, b, options) : 0.0;
        }
        if (per_speed > 0.0) pieces = std::max(pieces, relative_speed(*motion[own], *motion[j]) * per_speed);
      }
    }
  });
  double pieces = 1.0;
  for (const double p : most_of) pieces = std::max(pieces, p);
  return pieces;
}

double choose_substep(std::span<const WorldPart> parts, std::span<const double> v, std::span<const std::size_t> first_v,
                      const WorldOptions& options, double left, StepReport& report) {
  const double pieces = motion_pieces(parts, v, first_v, options, left, options.environment.gravity.norm() * left);
  const double remaining = std::max(1, options.max_substeps - report.substeps);
  double n = std::ceil(pieces - 1e-9);
  if (report.substeps == 0) n = std::max(n, static_cast<double>(options.min_substeps));
  if (n > remaining) {
    n = remaining;
    if (report.warnings.empty() || report.warnings.back().code != "substeps_capped")
      report.warnings.push_back({report.time, "substeps_capped",
                                 fmt::format("relative motion asks for {:.0f} sub-steps, max_substeps allows {}; "
                                             "bodies may pass through each other",
                                             std::ceil(pieces), options.max_substeps)});
  }
  return left / n;
}

}  // namespace brim
