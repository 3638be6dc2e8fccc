#include "brim/world/substeps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace brim {

double motion_pieces(std::span<const WorldPart> parts, std::span<const double> v, std::span<const std::size_t> first_v,
                     const WorldOptions& options, double time, double change) {
  struct Entry {
    Aabb box;  ///< swept over the time
    Vec3 carrier;
    double relative;  ///< [m/s] bound
    double h;
    std::int32_t part;
  };
  std::vector<Entry> entries(parts.size());
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const WorldPart& part = parts[p];
    const auto vb = v.subspan(first_v[part.body_index], first_v[part.body_index + 1] - first_v[part.body_index]);
    Entry& e = entries[p];
    e.carrier = part.body->carrier_velocity(part.index, vb);
    e.relative = part.body->relative_speed_bound(part.index, vb);
    if (!part.body->immobile()) e.relative += change;
    e.h = part.h;
    e.part = static_cast<std::int32_t>(p);
    e.box = part.body->bounds(part.index).inflated(0.5 * options.ramp_voxels * part.h + e.relative * time);
    e.box.extend(Aabb{e.box.lo + time * e.carrier, e.box.hi + time * e.carrier});
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.box.lo.x() != b.box.lo.x() ? a.box.lo.x() < b.box.lo.x() : a.part < b.part;
  });
  double pieces = 1.0;
  for (std::size_t i = 0; i < entries.size(); ++i)
    for (std::size_t j = i + 1; j < entries.size() && entries[j].box.lo.x() <= entries[i].box.hi.x(); ++j) {
      const Entry &a = entries[i], &b = entries[j];
      if (!a.box.overlaps(b.box)) continue;
      if (!may_touch(parts[a.part], parts[b.part])) continue;
      const double speed = (a.carrier - b.carrier).norm() + a.relative + b.relative;
      pieces = std::max(pieces, speed * time / (options.max_motion_voxels * std::min(a.h, b.h)));
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
