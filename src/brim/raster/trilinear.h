#pragma once

#include "brim/math/types.h"

namespace brim {

/// The trilinear interpolant in a cell of a grid, at one place.
struct Trilinear {
  double value = 0.0;
  Vec3 slope = Vec3::Zero();  ///< its gradient, per metre
};

/// Interpolates between the eight corners of a cell.  Tests: tests/raster/trilinear_test.cpp
/// @param t          place in the cell, 0 to 1 along each axis
/// @param h          [m] side of the cell
/// @param corner_at  corner_at(x, y, z), each 0 or 1: the value at a corner; called once for each, x fastest
template <class CornerAt>
Trilinear trilinear(const Vec3& t, double h, const CornerAt& corner_at) {
  Trilinear at;
  for (int corner = 0; corner < 8; ++corner) {
    const int x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
    const double value = corner_at(x, y, z);
    const double wx = x ? t[0] : 1.0 - t[0], wy = y ? t[1] : 1.0 - t[1], wz = z ? t[2] : 1.0 - t[2];
    at.value += wx * wy * wz * value;
    at.slope += value / h * Vec3((x ? 1.0 : -1.0) * wy * wz, wx * (y ? 1.0 : -1.0) * wz, wx * wy * (z ? 1.0 : -1.0));
  }
  return at;
}

}  // namespace brim
