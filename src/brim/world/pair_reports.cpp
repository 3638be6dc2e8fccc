#include "brim/world/pair_reports.h"

#include <fmt/format.h>

#include <algorithm>

#include "brim/body/filling.h"
#include "brim/core/interface_of.h"
#include "brim/core/parallel.h"
#include "brim/world/fill_stage.h"

namespace brim {

namespace {

/// Warns when elements of a body that fills space start inside the other part: its pressure throws both apart.
/// @param overlap  [voxels] of the deepest element, from its layer's place before the surface
void warn_of_drowned_start(const WorldPart& a, const WorldPart& b, double overlap, double time, StepReport& report) {
  constexpr double kInside = 0.2;  // of the layer's distance from a surface: what is random about a start is no fault
  const WorldPart &fluid = a.info.conforming ? a : b, &solid = a.info.conforming ? b : a;
  const double gap = interface_of<Filling>(*fluid.body)->fill_gap();
  const double inside = overlap * std::min(a.h, b.h) - gap;
  if (!(inside > kInside * gap)) return;
  report.warnings.push_back(
      {time, "start_overlap",
       fmt::format("'{}' starts up to {:.2g} m inside '{}', and they are thrown apart: leave that space out of the "
                   "fluid's shape by \"carve\", or place them apart",
                   fluid.body->name(), inside, solid.body->name())});
}

}  // namespace

void warn_of_saturation(std::span<const WorldPart> parts, const PairReport& r, double stiffness, double time,
                        StepReport& report) {
  if (!(r.worst_pressure > 0.6) || report.warnings.size() >= kMostWarnings) return;
  const WorldPart &a = parts[r.part_a], &b = parts[r.part_b];
  const bool placed = time == 0.0 && report.substeps == 1;  // nothing has moved yet
  if (placed) {
    report.warnings.push_back(
        {time, "saturation",
         fmt::format("'{}' and '{}' overlap by {:.2f} of full density at the start, where contact gives way; place "
                     "them apart",
                     a.body->name(), b.body->name(), r.worst_pressure)});
    return;
  }
  const std::string stiffer =
      stiffness > 0.0
          ? fmt::format("give the materials '{}' and '{}' a \"stiffness\" above {:.2g} Pa in \"pairs\", or ",
                        a.info.material.name, b.info.material.name, stiffness)
          : std::string();
  report.warnings.push_back(
      {time, "saturation",
       fmt::format(
           "'{}' and '{}' overlap by {:.2f} of full density, where contact gives way; {}lower the \"time_step\"",
           a.body->name(), b.body->name(), r.worst_pressure, stiffer)});
}

void warn_of_start(std::span<const WorldPart> parts, double time, StepReport& report) {
  constexpr double kDeep = 2.0;  // [voxels]
  for (const PairReport& r : report.pairs) {
    const WorldPart &a = parts[r.part_a], &b = parts[r.part_b];
    if (report.warnings.size() >= kMostWarnings) return;
    if (fills(a, b)) {
      warn_of_drowned_start(a, b, r.worst_overlap, time, report);
      continue;
    }
    // A conforming part starts where the other leaves room.
    const bool conforming = a.info.conforming || b.info.conforming;
    if (conforming || !(r.worst_overlap > kDeep)) continue;
    report.warnings.push_back(
        {time, "start_overlap",
         fmt::format(
             "'{}' and '{}' overlap by {:.2g} voxels at the start: they are pushed apart, or stay within each other; "
             "place them apart",
             a.body->name(), b.body->name(), r.worst_overlap)});
  }
}

void warn_of_mass_ratio(std::span<const WorldPart> parts, const ContactParameters& laws, const WorldOptions& options,
                        double time, StepReport& report) {
  // A load on a light box sinks by 0.01 voxel at 100 times its mass, 0.05 at 300, 0.3 to 1.3 at 1,000, and passes
  // through it at 10,000.
  constexpr double kRatio = 300.0, kCarried = 10.0;
  for (const PairReport& r : report.pairs) {
    const WorldPart &a = parts[r.part_a], &b = parts[r.part_b];
    if (is_fixed(a) || is_fixed(b)) continue;
    const double mass_a = a.body->mass(), mass_b = b.body->mass();
    const double light = std::min(mass_a, mass_b), heavy = std::max(mass_a, mass_b);
    const double load = r.force_on_a.norm();
    if (!(heavy >= kRatio * light) || !(load > kCarried * light * options.environment.gravity.norm())) continue;
    if (!laws.constraint_between(a, b, options).constrained) continue;
    if (report.warnings.size() >= kMostWarnings) return;
    report.warnings.push_back(
        {time, "mass_ratio",
         fmt::format("'{}' and '{}', whose masses differ by {:.2g} times, press on each other, and constraint rows do "
                     "not hold that: they sink in; make the light one heavier, or hold the pair by penalties",
                     a.body->name(), b.body->name(), heavy / light)});
  }
}

void report_pairs(std::span<const WorldPart> parts, const ContactSet& contacts, std::span<const PairState> parameters,
                  std::span<const Vec3> normal, std::span<const Vec3> friction, double time, StepReport& report,
                  std::vector<ContactSample>& samples) {
  samples.resize(contacts.first_link());
  report.pairs.clear();
  const auto pairs = std::span(contacts.pairs).first(contacts.first_link_pair());
  for (std::size_t first = 0, next = 0; first < pairs.size(); first = next) {
    // Self-contact occurs at several places.
    const std::int32_t a = pairs[first].part_a, b = pairs[first].part_b;
    while (next < pairs.size() && pairs[next].part_a == a && pairs[next].part_b == b) ++next;
    PairReport r;
    r.part_a = a, r.part_b = b;
    double load = 0.0;
    Vec3 weighted = Vec3::Zero();
    for (const ContactPair& pair : pairs.subspan(first, next - first)) {
      if (r.contacts == 0 && pair.begin < pair.end) r.center = contacts.point[pair.begin];
      r.contacts += static_cast<std::int32_t>(pair.end - pair.begin);
      for (std::size_t c = pair.begin; c < pair.end; ++c) {
        const double depth = contacts.depth[c] / pair.h;
        r.worst_overlap = std::max(r.worst_overlap, depth);
        r.worst_pressure = std::max(r.worst_pressure, double{contacts.overlap[c]});
        if (a != b) r.force_on_a += normal[c] + friction[c], r.friction_on_a += friction[c];
        const double weight = normal[c].norm();
        weighted += weight * contacts.point[c];
        load += weight;
        samples[c] = {contacts.point[c].cast<float>(),
                      normal[c].cast<float>(),
                      friction[c].cast<float>(),
                      static_cast<float>(depth),
                      a,
                      b};
      }
    }
    if (r.contacts == 0) continue;
    if (load > 0.0) r.center = weighted / load;
    report.worst_overlap = std::max(report.worst_overlap, r.worst_overlap);
    warn_of_saturation(parts, r, parameters[first].stiffness, time, report);
    report.pairs.push_back(r);
  }
  if (contacts.engulfed > 0 && report.warnings.size() < kMostWarnings)
    report.warnings.push_back(
        {time, "engulfed", fmt::format("{} nodes lie deep inside two parts and push neither way", contacts.engulfed)});
}

void add_impulses(std::span<const WorldPart> parts, std::size_t bodies, double dt, StepReport& report) {
  report.impulse.resize(bodies, Vec3::Zero());
  for (const PairReport& pair : report.pairs) {
    report.impulse[parts[pair.part_a].body_index] += dt * pair.force_on_a;
    report.impulse[parts[pair.part_b].body_index] -= dt * pair.force_on_a;
  }
}

}  // namespace brim
