#include "brim/mesh/distance_row.h"

#include <cstddef>
#include <cstring>

#include "brim/core/simd.h"
#include "brim/mesh/distance_bounds.h"
#include "brim/mesh/kinked_cubic.h"

namespace brim {

namespace {

typedef float FourFloats __attribute__((vector_size(4 * sizeof(float))));

/// Tricubic values in single precision at the points x0 + i dx (in spacings from the first node) for every bit i of
/// `wanted`.
/// @param cells  one less than the number of nodes per axis  @param inverse  [1/m] of the spacing
/// @return the bits of points that are in no inner cell
BRIM_WIDE std::uint8_t tricubic_row(const float* values, const int* cells, std::ptrdiff_t nx, std::ptrdiff_t nxy,
                                    const double* x0, const double* dx, float inverse, std::uint8_t wanted,
                                    float* out) {
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
    const float t[3] = {static_cast<float>(x - static_cast<double>(cx)),
                        static_cast<float>(y - static_cast<double>(cy)),
                        static_cast<float>(z - static_cast<double>(cz))};
    const float* first = values + (cx - 1) + nx * (cy - 1) + nxy * (cz - 1);
    // Along z in all 16 lines at once, then along y in four, then along x.
    WidestFloats plane[4];
    for (int m = 0; m < 4; ++m)
      for (int l = 0; l < 4; ++l)
        std::memcpy(reinterpret_cast<float*>(&plane[m]) + 4 * l, first + l * nx + m * nxy, 4 * sizeof(float));
    const WidestFloats lines =
        kinked_cubic(plane[0], plane[1], plane[2], plane[3], WidestFloats{} + t[2], WidestFloats{} + inverse);
    FourFloats line[4];
    std::memcpy(line, &lines, sizeof line);
    const FourFloats r = kinked_cubic(line[0], line[1], line[2], line[3], FourFloats{} + t[1], FourFloats{} + inverse);
    out[i] = kinked_cubic(float{r[0]}, float{r[1]}, float{r[2]}, float{r[3]}, t[0], inverse);
  }
  return left;
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
  if (left != 0 && grid.interpolation() == Interpolation::Tricubic) {
    const Vec3i cells = grid.nodes() - Vec3i::Ones();
    const std::ptrdiff_t nx = grid.nodes().x();
    left = tricubic_row(grid.values().data(), cells.data(), nx, nx * grid.nodes().y(), x0.data(), dx.data(),
                        static_cast<float>(inverse), left, out);
  }
  for (int i = 0; i < 8; ++i)
    if (left >> i & 1) out[i] = static_cast<float>(grid.value(start + i * step));
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
