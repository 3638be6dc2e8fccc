#include "brim/world/substeps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "brim/body/motion_clusters.h"
#include "brim/core/parallel.h"
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
                         part.body->relative_speed_bound(part.index, vb) + (part.body->immobile() ? 0.0 : change);
    second = std::max(second, std::min(fastest, speed));
    fastest = std::max(fastest, speed);
    h = std::min(h, part.h);
  }
  return (fastest + second) * time / (options.max_motion_voxels * h);
}

}  // namespace

double motion_limit(const WorldPart& a, const WorldPart& b, const WorldOptions& options) {
  const double h = std::min(a.h, b.h);
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
  struct Entry {
    Aabb swept;  ///< [m] over the time
    MotionCluster motion;
    std::int32_t part;
  };
  std::vector<std::vector<MotionCluster>> clusters(parts.size());
  parallel_for(parts.size(), [&](std::size_t p) {
    const WorldPart& part = parts[p];
    const auto vb = v.subspan(first_v[part.body_index], first_v[part.body_index + 1] - first_v[part.body_index]);
    if (const auto* moving = dynamic_cast<const MotionClusters*>(part.body))
      moving->motion_clusters(part.index, vb, clusters[p]);
    if (!clusters[p].empty()) return;
    const Vec3 mean = part.body->carrier_velocity(part.index, vb);
    clusters[p].push_back(
        {part.body->bounds(part.index), {mean, mean}, part.body->relative_speed_bound(part.index, vb)});
  });
  std::vector<Entry> entries;
  for (std::size_t p = 0; p < parts.size(); ++p)
    for (MotionCluster& c : clusters[p]) {
      if (!parts[p].body->immobile()) c.deviation += change;
      const Aabb now = c.box.inflated(0.5 * options.ramp_voxels * parts[p].h + c.deviation * time);
      Aabb swept = now;
      swept.extend(Aabb{now.lo + time * c.velocity.lo, now.hi + time * c.velocity.hi});
      entries.push_back({swept, c, static_cast<std::int32_t>(p)});
    }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.swept.lo.x() != b.swept.lo.x() ? a.swept.lo.x() < b.swept.lo.x() : a.part < b.part;
  });
  double pieces = 1.0;
  for (std::size_t i = 0; i < entries.size(); ++i)
    for (std::size_t j = i + 1; j < entries.size() && entries[j].swept.lo.x() <= entries[i].swept.hi.x(); ++j) {
      const Entry &a = entries[i], &b = entries[j];
      if (a.part == b.part || !a.swept.overlaps(b.swept)) continue;
      if (!may_touch(parts[a.part], parts[b.part])) continue;
      const double most = motion_limit(parts[a.part], parts[b.part], options);
      pieces = std::max(pieces, relative_speed(a.motion, b.motion) * time / most);
    }
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
