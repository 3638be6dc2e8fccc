#pragma once

#include "brim/math/types.h"

namespace brim {

/// Volume fraction of the ball of diameter w about p inside a solid centred at the origin, [-]; ramp(d, w) where the
/// surface is flat within the ball. Sizes as for make_sphere and the others, but half extents and lengths, [m].
/// Tests: tests/raster/ball_share_test.cpp

/// Lens of two balls.
double ball_share_of_sphere(const Vec3& p, double w, double radius);
/// Product of the fractions of three slabs: exact at faces, 1/4 on an edge and 1/8 at a corner as for a ball, and
/// within 0.04 of the ball's in between.
double ball_share_of_box(const Vec3& p, double w, const Vec3& half);
/// By slices along z: the lens of two discs, integrated with eight points; error below 1e-3.
double ball_share_of_cylinder(const Vec3& p, double w, double radius, double half);
double ball_share_of_capsule(const Vec3& p, double w, double radius, double half);
double ball_share_of_torus(const Vec3& p, double w, double radius, double tube);
/// @param middle, half  [m] radius of the middle of the shell, half its thickness
double ball_share_of_bowl(const Vec3& p, double w, double middle, double half);
double ball_share_of_cup(const Vec3& p, double w, double radius, double height, double thickness);

}  // namespace brim
