#include "brim/world/substeps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "brim/body/longest_step.h"
#include "brim/body/spinning_balls.h"
#include "brim/core/interface_of.h"
#include "brim/world/contact_parameters.h"
#include "brim/world/links.h"
#include "brim/world/motion_search.h"

namespace brim {

namespace {

/// Share of the combined thickness of two parts that they may move in one sub-step.
constexpr double kShareOfThickness = 0.25;
/// [voxels] assumed for a part of unknown thickness: voxels are chosen so that two fit.
constexpr double kLeastThickness = 2.0;

/// [radii] by which a ball may fall in one sub-step. Heaps of 588 balls of 10 mm move at 1.0 to 8.8 mm/s (root mean
/// square) after 3 s at 0.27, and at 0.3 to 1.3 mm/s at 0.07 (heap_rests of docs/validation.md).
constexpr double kFallOfBalls = 0.16;

/// The part that moves by the most of its voxels.
struct FastestPart {
  const WorldPart* part = nullptr;
  double speed = 0.0;  ///< [m/s]
};

FastestPart fastest_of(std::span<const WorldPart> parts, std::span<const double> v,
                       std::span<const std::size_t> first_v) {
  FastestPart fastest;
  for (const WorldPart& part : parts) {
    const double speed = speed_bound(part, velocities_of(part, v, first_v));
    if (fastest.part == nullptr || speed / part.h > fastest.speed / fastest.part->h) fastest = {&part, speed};
  }
  return fastest;
}

/// Why sub-steps of a length [s] are too long, what may come of it and what helps.
std::string text_of_cap(const NeededPieces& needed, const FastestPart& fastest, const WorldOptions& options,
                        double length) {
  const std::string cure = "a smaller \"time_step\" or a larger \"max_substeps\"";
  const double links = std::max(needed.swing, needed.spin);
  if (needed.motion >= std::max({needed.fall, needed.inner, links}) && fastest.part != nullptr)
    return fmt::format(
        "bodies move too fast for the {} sub-steps that max_substeps allows: the fastest, '{}' at {:.3g} m/s, moves "
        "by {:.3g} voxels in each and may pass through others; a smaller \"time_step\", a larger \"max_substeps\" or "
        "a coarser \"voxel_size\" prevents that",
        options.max_substeps, fastest.part->body->name(), fastest.speed, fastest.speed * length / fastest.part->h);
  if (needed.spin >= std::max({needed.fall, needed.inner, needed.swing}))
    return fmt::format(
        "bodies between joints or attachments spin by more than {:.2g} rad in each of the {} sub-steps that "
        "max_substeps allows: joints beside their middles may gain energy; {} prevents that",
        Links::kSpin, options.max_substeps, cure);
  if (needed.swing >= std::max(needed.fall, needed.inner))
    return fmt::format(
        "light bodies between joints or attachments that pull hard need shorter sub-steps than the {} that "
        "max_substeps allows, {:.2g} s each: they may swing ever faster; {}, or heavier ones, prevent that",
        options.max_substeps, length, cure);
  if (needed.inner >= needed.fall)
    return fmt::format(
        "inner forces of bodies need shorter sub-steps than the {} that max_substeps allows, {:.2g} s "
        "each: bodies may burst; {} prevents that",
        options.max_substeps, length, cure);
  return fmt::format(
      "balls fall too far in each of the {} sub-steps that max_substeps allows: heaps of them may not "
      "come to rest; {} prevents that",
      options.max_substeps, cure);
}

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
  return MotionSearch({parts, v, first_v, options, time, change, held, along}, sweep).pieces();
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

double stable_pieces(std::span<const WorldPart> parts, double time) {
  double longest = std::numeric_limits<double>::infinity();
  for (const WorldPart& part : parts)
    if (const auto* body = interface_of<LongestStep>(*part.body)) longest = std::min(longest, body->longest_step());
  return std::max(1.0, time / longest);
}

double choose_substep(const NeededPieces& needed, std::span<const WorldPart> parts, std::span<const double> v,
                      std::span<const std::size_t> first_v, const WorldOptions& options, double left,
                      StepReport& report) {
  const double remaining = std::max(1, options.max_substeps - report.substeps);
  const double asked = std::max({needed.motion, needed.fall, needed.inner, needed.swing, needed.spin,
                                 options.min_substeps * left / options.time_step});
  double n = std::ceil(asked - 1e-9);
  if (n > remaining) {
    n = remaining;
    if (report.warnings.empty() || report.warnings.back().code != "substeps_capped")
      report.warnings.push_back(
          {report.time, "substeps_capped", text_of_cap(needed, fastest_of(parts, v, first_v), options, left / n)});
  }
  return left / n;
}

}  // namespace brim
