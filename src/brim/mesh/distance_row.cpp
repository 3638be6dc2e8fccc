#include "brim/mesh/distance_row.h"

#include <cstddef>
#include <cstring>
#include <type_traits>

#include "brim/core/simd.h"
#include "brim/mesh/distance_bounds.h"
#include "brim/mesh/kinked_cubic.h"

namespace brim {

namespace {

typedef float FourFloats __attribute__((vector_size(4 * sizeof(float))));

/// Places within cells, and the 64 nodes around each.
struct CellPlaces {
  const float* first[8];
  float x[8] = {}, y[8] = {}, z[8] = {};
  int count = 0;
};

/// Catmull and Rom's cubic.
BRIM_INLINE float smooth_value(const float* first, std::ptrdiff_t nx, std::ptrdiff_t nxy, float x, float y, float z) {
  const FourFloats t = {x, y, z, 0.0f}, t2 = t * t, t3 = t2 * t;
  const FourFloats w0 = 0.5f * (2.0f * t2 - t3 - t), w1 = 0.5f * (3.0f * t3 - 5.0f * t2 + 2.0f),
                   w2 = 0.5f * (4.0f * t2 - 3.0f * t3 + t), w3 = 0.5f * (t3 - t2);
  const FourFloats wx = {w0[0], w1[0], w2[0], w3[0]};
  const float wy[4] = {w0[1], w1[1], w2[1], w3[1]}, wz[4] = {w0[2], w1[2], w2[2], w3[2]};
  FourFloats sum = {};
  for (int m = 0; m < 4; ++m) {
    FourFloats plane = {};
    for (int l = 0; l < 4; ++l) plane += wy[l] * load_lanes(first + l * nx + m * nxy);
    sum += wz[m] * plane;
  }
  sum *= wx;
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

BRIM_INLINE WidestFloats joined(const FourFloats& a, const FourFloats& b, const FourFloats& c, const FourFloats& d) {
  const WideFloats low = __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7),
                   high = __builtin_shufflevector(c, d, 0, 1, 2, 3, 4, 5, 6, 7);
  return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
}

/// Values at up to four of the places from p on, where kinks may be felt: along z in all 16 lines of a place at once,
/// along y in those of all places, and along x.
BRIM_INLINE FourFloats kinked_values(const CellPlaces& at, int p, std::ptrdiff_t nx, std::ptrdiff_t nxy,
                                     float inverse) {
  const WidestFloats all = WidestFloats{} + inverse;
  WidestFloats z[4] = {};
  for (int i = 0; i < 4 && p + i < at.count; ++i) {
    WidestFloats plane[4];
    for (int m = 0; m < 4; ++m) {
      const float* line = at.first[p + i] + m * nxy;
      plane[m] = joined(load_lanes(line), load_lanes(line + nx), load_lanes(line + 2 * nx), load_lanes(line + 3 * nx));
    }
    z[i] = kinked_cubic(plane[0], plane[1], plane[2], plane[3], WidestFloats{} + at.z[p + i], all);
  }
  // Line l of each place: its four numbers along x.
  const auto line = [&](const WidestFloats& v, auto l) BRIM_LAMBDA_INLINE {
    constexpr int k = 4 * decltype(l)::value;
    return FourFloats(__builtin_shufflevector(v, v, k, k + 1, k + 2, k + 3));
  };
  const auto lines = [&](auto l) BRIM_LAMBDA_INLINE {
    return joined(line(z[0], l), line(z[1], l), line(z[2], l), line(z[3], l));
  };
  const FourFloats ty = {at.y[p], at.y[p + 1], at.y[p + 2], at.y[p + 3]},
                   tx = {at.x[p], at.x[p + 1], at.x[p + 2], at.x[p + 3]};
  const WidestFloats y =
      kinked_cubic(lines(std::integral_constant<int, 0>()), lines(std::integral_constant<int, 1>()),
                   lines(std::integral_constant<int, 2>()), lines(std::integral_constant<int, 3>()),
                   WidestFloats(__builtin_shufflevector(ty, ty, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3)), all);
  return kinked_cubic(FourFloats(__builtin_shufflevector(y, y, 0, 4, 8, 12)),
                      FourFloats(__builtin_shufflevector(y, y, 1, 5, 9, 13)),
                      FourFloats(__builtin_shufflevector(y, y, 2, 6, 10, 14)),
                      FourFloats(__builtin_shufflevector(y, y, 3, 7, 11, 15)), tx, FourFloats{} + inverse);
}

/// Tricubic values in single precision at the points x0 + i dx (in spacings from the first node) for every bit i of
/// `wanted`.
/// @param cells  one less than the number of nodes per axis  @param kinks  of KinkedCells
/// @param exact  of ExactCells, or null
/// @param inverse  [1/m] of the spacing  @return the bits of points that are in no inner cell, or in an exact one
BRIM_WIDE std::uint8_t tricubic_row(const float* values, const std::uint32_t* kinks, const std::uint32_t* exact,
                                    const int* cells, std::ptrdiff_t nx, std::ptrdiff_t nxy, const double* x0,
                                    const double* dx, float inverse, std::uint8_t wanted, float* out) {
  std::uint8_t left = 0;
  CellPlaces kinked;
  int of[8];
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
    const std::ptrdiff_t node = cx + nx * cy + nxy * cz;
    const float* first = values + node - 1 - nx - nxy;
    const auto tx = static_cast<float>(x - static_cast<double>(cx)),
               ty = static_cast<float>(y - static_cast<double>(cy)),
               tz = static_cast<float>(z - static_cast<double>(cz));
    if (!KinkedCells::holds(kinks, static_cast<std::size_t>(node))) {
      out[i] = smooth_value(first, nx, nxy, tx, ty, tz);
      continue;
    }
    if (exact != nullptr && KinkedCells::holds(exact, static_cast<std::size_t>(node))) {
      left |= static_cast<std::uint8_t>(1 << i);
      continue;
    }
    const int n = kinked.count++;
    kinked.first[n] = first, kinked.x[n] = tx, kinked.y[n] = ty, kinked.z[n] = tz, of[n] = i;
  }
  for (int p = 0; p < kinked.count; p += 4) {
    const FourFloats value = kinked_values(kinked, p, nx, nxy, inverse);
    for (int i = 0; i < 4 && p + i < kinked.count; ++i) out[of[p + i]] = value[i];
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
    left = tricubic_row(grid.values().data(), grid.kinks().bits(),
                        grid.exact_cells() != nullptr ? grid.exact_cells()->bits() : nullptr, cells.data(), nx,
                        nx * grid.nodes().y(), x0.data(), dx.data(), static_cast<float>(inverse), left, out);
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
