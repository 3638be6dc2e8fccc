#include "brim/raster/place_distances.h"

#include <algorithm>
#include <cmath>

#include "brim/core/simd.h"

namespace brim {

BRIM_WIDE void sphere_distances(const PlaceArrays& at, double radius, double* __restrict d) {
  for (int i = 0; i < at.count; ++i)
    d[i] = std::sqrt(at.x[i] * at.x[i] + at.y[i] * at.y[i] + at.z[i] * at.z[i]) - radius;
}

BRIM_WIDE void box_distances(const PlaceArrays& at, const Vec3& half, double* __restrict d) {
  const double hx = half[0], hy = half[1], hz = half[2];
  for (int i = 0; i < at.count; ++i) {
    const double x = std::abs(at.x[i]) - hx, y = std::abs(at.y[i]) - hy, z = std::abs(at.z[i]) - hz;
    const double ox = std::max(x, 0.0), oy = std::max(y, 0.0), oz = std::max(z, 0.0);
    d[i] = std::sqrt(ox * ox + oy * oy + oz * oz) + std::min(std::max(x, std::max(y, z)), 0.0);
  }
}

BRIM_WIDE void capsule_distances(const PlaceArrays& at, double radius, double half, double* __restrict d) {
  for (int i = 0; i < at.count; ++i) {
    const double z = at.z[i] - std::clamp(at.z[i], -half, half);
    d[i] = std::sqrt(at.x[i] * at.x[i] + at.y[i] * at.y[i] + z * z) - radius;
  }
}

}  // namespace brim
