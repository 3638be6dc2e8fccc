#pragma once

#include <optional>

#include "brim/math/types.h"

namespace brim {

/// Two balls that come nearer to each other: where they stand to each other when they touch.
struct RoundImpact {
  double time = 0.0;           ///< [s] until they touch; the end of the step, or of the approach, if they do not
  Vec3 normal = Vec3::Zero();  ///< unit, towards a, at that time
  double gap = 0.0;            ///< [m] along that normal at the start: it closes at the time of the touch
};

/// Normals at the start of a step are not those of an oblique impact within it: at 2 m/s balls of 0.1 m turn about each
/// other by up to ten degrees in a sixtieth of a second. In free flight the line of centres D + u t has the length of
/// both radii when they touch, and n is its direction then (|D + u t| = r, n = (D + u t) / r, gap = n·D − r).
/// @param apart  D, [m] from the centre of b to that of a, longer than `radii`  @param velocity  u, [m/s] of a relative
/// to b  @param radii  r, [m] sum of both  @param dt  [s] of the step
/// @return none when they do not come nearer
/// Tests: tests/response/round_impact_test.cpp
std::optional<RoundImpact> find_round_impact(const Vec3& apart, const Vec3& velocity, double radii, double dt);

}  // namespace brim
