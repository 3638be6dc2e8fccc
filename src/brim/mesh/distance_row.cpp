#include "brim/mesh/distance_row.h"

#include <algorithm>
#include <cstring>

#include "brim/core/simd.h"
#include "brim/mesh/distance_bounds.h"
#include "brim/mesh/tricubic_cells.h"

namespace brim {

namespace {

/// Tricubic values at the points x0 + i dx (in spacings from the first node) for every bit i of `wanted`.
/// @return the bits of points that are in no inner cell, or in an exact one
BRIM_WIDE std::uint8_t tricubic_row(const TricubicCells& cells, const double* x0, const double* dx, std::uint8_t wanted,
                                    float* out) {
  return tricubic::values_at<8>(
      cells, wanted,
      [&](int i, double* x) BRIM_LAMBDA_INLINE {
        for (int k = 0; k < 3; ++k) x[k] = x0[k] + i * dx[k];
      },
      out);
}

/// The same at any places, [m], about the first node. @param count  up to 64
BRIM_WIDE std::uint64_t tricubic_places(const TricubicCells& cells, const double* origin, double inverse,
                                        const double* px, const double* py, const double* pz, int count, float* out) {
  return tricubic::values_at<64>(
      cells, ~std::uint64_t{0} >> (64 - count),
      [&](int i, double* x) BRIM_LAMBDA_INLINE {
        x[0] = (px[i] - origin[0]) * inverse, x[1] = (py[i] - origin[1]) * inverse,
        x[2] = (pz[i] - origin[2]) * inverse;
      },
      out);
}

/// The bounds at the points x0 + i dx (in spacings from the first node) that are beyond reach, [spacings], in metres.
/// @return the bits of the wanted points where they are not
BRIM_WIDE std::uint8_t bound_row(const DistanceBounds& bounds, const double* x0, const double* dx, float reach,
                                 float spacing, std::uint8_t wanted, float* out) {
  const WideFloats step = {0.0f, 1.0f, 2.0f, 3.0f, 4.0f, 5.0f, 6.0f, 7.0f};
  WideFloats x[3];
  for (int a = 0; a < 3; ++a) x[a] = static_cast<float>(x0[a]) + static_cast<float>(dx[a]) * step;
  const DistanceBounds::Range r = bounds.at(x[0], x[1], x[2]);
  const WideIds bit = {1, 2, 4, 8, 16, 32, 64, 128}, asked = ((WideIds{} + std::int32_t{wanted}) & bit) != 0;
  const WideIds over = asked & (r.least > reach), under = asked & (r.most < -reach), far = over | under;
  WideFloats kept;
  std::memcpy(&kept, out, sizeof kept);
  const WideFloats told = spacing * (over ? r.least : r.most), now = far ? told : kept;
  std::memcpy(out, &now, sizeof now);
  return static_cast<std::uint8_t>(wanted & ~bits_of(far));
}

BRIM_WIDE void least_row(const DistanceBounds& bounds, const float* x0, const float* dx, const float* dy,
                         const float* dz, const float* i, const float* j, const float* k, float spacing, float* out) {
  WideFloats wi, wj, wk, x[3];
  std::memcpy(&wi, i, sizeof wi), std::memcpy(&wj, j, sizeof wj), std::memcpy(&wk, k, sizeof wk);
  for (int a = 0; a < 3; ++a) x[a] = x0[a] + wi * dx[a] + wj * dy[a] + wk * dz[a];
  const WideFloats least = spacing * bounds.at(x[0], x[1], x[2]).least;
  std::memcpy(out, &least, sizeof least);
}

}  // namespace

void distance_row(const DistanceGrid& grid, const Vec3& start, const Vec3& step, std::uint8_t wanted, double reach,
                  float* out) {
  const double inverse = grid.inverse_spacing();
  const Vec3 x0 = (start - grid.origin()) * inverse, dx = step * inverse;
  std::uint8_t left = bound_row(DistanceBounds(grid), x0.data(), dx.data(), static_cast<float>(reach * inverse),
                                static_cast<float>(grid.spacing()), wanted, out);
  if (left != 0 && grid.interpolation() == Interpolation::Tricubic)
    left = tricubic_row(TricubicCells(grid), x0.data(), dx.data(), left, out);
  for (int i = 0; i < 8; ++i)
    if (left >> i & 1) out[i] = static_cast<float>(grid.value(start + i * step));
}

void distance_places(const DistanceGrid& grid, const double* x, const double* y, const double* z, int count,
                     double* out) {
  const TricubicCells cells(grid);
  for (int first = 0; first < count; first += 64) {
    const int n = std::min(64, count - first);
    std::uint64_t left = ~std::uint64_t{0} >> (64 - n);
    float values[64];
    if (grid.interpolation() == Interpolation::Tricubic)
      left = tricubic_places(cells, grid.origin().data(), grid.inverse_spacing(), x + first, y + first, z + first, n,
                             values);
    for (int i = 0; i < n; ++i) {
      const int p = first + i;
      out[p] = (left >> i & 1) != 0 ? grid.value({x[p], y[p], z[p]}) : double{values[i]};
    }
  }
}

void least_values(const DistanceGrid& grid, const Vec3& start, const Vec3& dx, const Vec3& dy, const Vec3& dz,
                  const float* i, const float* j, const float* k, float* out) {
  const double inverse = grid.inverse_spacing();
  const auto scaled = [&](const Vec3& v) { return Vec3f((v * inverse).cast<float>()); };
  const Vec3f x0 = scaled(start - grid.origin()), x = scaled(dx), y = scaled(dy), z = scaled(dz);
  least_row(DistanceBounds(grid), x0.data(), x.data(), y.data(), z.data(), i, j, k, static_cast<float>(grid.spacing()),
            out);
}

}  // namespace brim
