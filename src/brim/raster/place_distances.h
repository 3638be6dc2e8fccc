#pragma once

#include "brim/math/types.h"

namespace brim {

/// Points in the frame of a shape, [m], structure of arrays.
struct PlaceArrays {
  const double *x, *y, *z;
  int count;
};

/// Signed distances, [m], of solids about the origin at many points, as many at a time as the machine has lanes; sizes
/// are half extents and lengths. Same bits as the formula at one point (raster/shape.cpp).
/// Tests: tests/raster/place_distances_test.cpp
void sphere_distances(const PlaceArrays& at, double radius, double* d);
void box_distances(const PlaceArrays& at, const Vec3& half, double* d);
void capsule_distances(const PlaceArrays& at, double radius, double half, double* d);

}  // namespace brim
