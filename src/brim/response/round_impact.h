#pragma once

#include <optional>

#include "brim/math/types.h"
#include "brim/response/moved_rows.h"

namespace brim {

/// Two surfaces that are round where they meet: balls, or a ball and the side of a capsule or a cylinder, or two such
/// sides with parallel axes.
struct RoundContact {
  double radius_a = 0.0, radius_b = 0.0;  ///< [m] both > 0, or 0 where not both are round, or one is an edge
  Vec3 flat = Vec3::Zero();               ///< unit, along the axis in which one is flat; zero for balls
  bool side_b = false;                    ///< b is flat along it
  bool any() const { return radius_a > 0.0; }
};

/// From the curvatures of a row. @param h  [m] grid step: radii from one to a thousand steps count
RoundContact round_contact(const RowPoint& row, double h);

/// Two balls that come nearer to each other: where they stand to each other when they touch.
struct RoundImpact {
  double time = 0.0;           ///< [s] until they touch; the end of the step, or of the approach, if they do not
  Vec3 normal = Vec3::Zero();  ///< unit, towards a, at that time
  double gap = 0.0;            ///< [m] along that normal at the start: it closes at the time of the touch
};

/// Normals at the start of a step are not those of an oblique impact within it: at 2 m/s balls of 0.1 m turn about each
/// other by up to ten degrees in a sixtieth of a second. In free flight the line of centres D + u t has the length of
/// both radii when they touch, and n is its direction then (|D + u t| = r, n = (D + u t) / r, gap = n·D − r). About the
/// axis of a side the same holds for D and u without their parts along it.
/// @param apart  D, [m] from the centre of b to that of a, longer than `radii`  @param velocity  u, [m/s] of a relative
/// to b  @param radii  r, [m] sum of both  @param dt  [s] of the step
/// @return none when they do not come nearer
/// Tests: tests/response/round_impact_test.cpp
std::optional<RoundImpact> find_round_impact(const Vec3& apart, const Vec3& velocity, double radii, double dt);

}  // namespace brim
