#pragma once

#include <optional>

#include "brim/mesh/ray.h"
#include "brim/raster/shape.h"

/// Queries of one placed solid. Exact to rounding for shapes whose distance is a formula; solids from meshes and images
/// are those that contact sees, within a small part of the spacing of their samples.
/// Tests: tests/raster/shape_queries_test.cpp
namespace brim {

/// First point of a ray on the solid. A ray that begins inside meets it at distance 0, with the normal against the ray.
/// Convex solids with a gradient: Newton's steps, which stay outside because the distance along a ray is convex.
/// Others: steps as long as the distance (sphere tracing; Hart 1996), then bisection. There a ray that is inside for
/// less than 1e-5 of the solid's size may miss it.
std::optional<RayEntry> enter(const Ray& ray, const Shape& shape, const Pose& pose);

/// Nearest point of the solid's surface. Where several are equally near, one of them. From samples: the nearest of
/// those around, found by projections, which in folded solids need not be the nearest of all.
NearPoint nearest(const Vec3& p, const Shape& shape, const Pose& pose);

/// True when the solid has matter in a box. Exact for convex solids with a gradient (within_reach); others are searched
/// down to 1/128 of the box, and each piece of it is projected onto the solid.
/// @param box  of the box's centre  @param half  [m] half of its extents
bool meets_box(const Shape& shape, const Pose& pose, const Pose& box, const Vec3& half);

}  // namespace brim
