#pragma once

#include "brim/math/types.h"

namespace brim {

/// Share of matter in the ball of diameter w about p, [-], of solids about the origin; where their surface is flat
/// within the ball it is ramp(d, w). Sizes as make_sphere and the others take them, but half extents and lengths, [m].
/// Tests: tests/raster/ball_share_test.cpp

/// The lens that two balls share.
double ball_share_of_sphere(const Vec3& p, double w, double radius);
/// The product of the shares of three slabs: exact at faces, 1/4 on an edge and 1/8 at a corner as in a ball, and
/// within 0.04 of the ball's between.
double ball_share_of_box(const Vec3& p, double w, const Vec3& half);
/// By slices along z: the lens of two discs, integrated over eight points; within 1e-3.
double ball_share_of_cylinder(const Vec3& p, double w, double radius, double half);
double ball_share_of_capsule(const Vec3& p, double w, double radius, double half);

}  // namespace brim
