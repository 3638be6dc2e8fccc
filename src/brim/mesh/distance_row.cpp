#include "brim/mesh/distance_row.h"

#include <cstddef>
#include <cstring>

#include "brim/core/simd.h"

namespace brim {

namespace {

typedef float FourFloats __attribute__((vector_size(4 * sizeof(float))));

/// Catmull-Rom in single precision at the points x0 + i dx (in spacings from the first node) for every bit i of
/// `wanted`.
/// @param cells  one less than the number of nodes per axis  @return the bits of points that are in no inner cell
BRIM_WIDE std::uint8_t tricubic_row(const float* values, const int* cells, std::ptrdiff_t nx, std::ptrdiff_t nxy,
                                    const double* x0, const double* dx, std::uint8_t wanted, float* out) {
  std::uint8_t left = 0;
  for (int i = 0; i < 8; ++i) {
    if (!(wanted >> i & 1)) continue;
    const double x = x0[0] + i * dx[0], y = x0[1] + i * dx[1], z = x0[2] + i * dx[2];
    // Inner cells have all 64 nodes: from 1 to cells - 2.
    if (!(x >= 1.0 && y >= 1.0 && z >= 1.0 && x < cells[0] - 1.0 && y < cells[1] - 1.0 && z < cells[2] - 1.0)) {
      left |= static_cast<std::uint8_t>(1 << i);
      continue;
    }
    const auto cx = static_cast<std::ptrdiff_t>(x), cy = static_cast<std::ptrdiff_t>(y),
               cz = static_cast<std::ptrdiff_t>(z);
    const FourFloats t = {static_cast<float>(x - static_cast<double>(cx)),
                          static_cast<float>(y - static_cast<double>(cy)),
                          static_cast<float>(z - static_cast<double>(cz)), 0.0f};
    const FourFloats t2 = t * t, t3 = t2 * t;
    const FourFloats w0 = 0.5f * (2.0f * t2 - t3 - t), w1 = 0.5f * (3.0f * t3 - 5.0f * t2 + 2.0f),
                     w2 = 0.5f * (4.0f * t2 - 3.0f * t3 + t), w3 = 0.5f * (t3 - t2);
    const FourFloats wx = {w0[0], w1[0], w2[0], w3[0]};
    const float wy[4] = {w0[1], w1[1], w2[1], w3[1]}, wz[4] = {w0[2], w1[2], w2[2], w3[2]};
    const float* first = values + (cx - 1) + nx * (cy - 1) + nxy * (cz - 1);
    FourFloats sum = {};
    for (int m = 0; m < 4; ++m) {
      FourFloats plane = {};
      for (int l = 0; l < 4; ++l) {
        FourFloats row;
        std::memcpy(&row, first + l * nx + m * nxy, sizeof row);
        plane += wy[l] * row;
      }
      sum += wz[m] * plane;
    }
    sum *= wx;
    out[i] = (sum[0] + sum[1]) + (sum[2] + sum[3]);
  }
  return left;
}

}  // namespace

void distance_row(const DistanceGrid& grid, const Vec3& start, const Vec3& step, std::uint8_t wanted, float* out) {
  std::uint8_t left = wanted;
  if (grid.interpolation() == Interpolation::Tricubic) {
    const double inverse = 1.0 / grid.spacing();
    const Vec3 x0 = (start - grid.origin()) * inverse, dx = step * inverse;
    const Vec3i cells = grid.nodes() - Vec3i::Ones();
    const std::ptrdiff_t nx = grid.nodes().x();
    left =
        tricubic_row(grid.values().data(), cells.data(), nx, nx * grid.nodes().y(), x0.data(), dx.data(), wanted, out);
  }
  for (int i = 0; i < 8; ++i)
    if (left >> i & 1) out[i] = static_cast<float>(grid.value(start + i * step));
}

}  // namespace brim
