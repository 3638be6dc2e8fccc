#pragma once

#include <cstddef>
#include <cstdint>

#include "brim/core/simd.h"
#include "brim/mesh/distance_grid.h"
#include "brim/mesh/kinked_cubic.h"

namespace brim {

/// Single-precision tricubic values of a distance grid, for functions that are compiled with wide instructions.
/// Tests: tests/mesh/distance_row_test.cpp
struct TricubicCells {
  explicit TricubicCells(const DistanceGrid& grid)
      : values(grid.values().data()),
        kinks(grid.kinks().bits()),
        exact(grid.exact_cells() != nullptr ? grid.exact_cells()->bits() : nullptr),
        nx(grid.nodes().x()),
        nxy(nx * grid.nodes().y()),
        inverse(static_cast<float>(grid.inverse_spacing())) {
    for (int k = 0; k < 3; ++k) last[k] = grid.nodes()[k] - 2.0;
  }

  const float* values;
  const std::uint32_t *kinks, *exact;  ///< of KinkedCells and of ExactCells, or null
  std::ptrdiff_t nx, nxy;              ///< nodes from line to line and from plane to plane
  float inverse;                       ///< [1/m] of the spacing
  double last[3];                      ///< inner cells, which have all 64 nodes, begin at 1 and end here
};

namespace tricubic {

/// Places within cells where kinks may be felt, and the first of the 64 nodes around each.
template <int kMost>
struct KinkedPlaces {
  const float* first[kMost];
  float x[kMost + 3], y[kMost + 3], z[kMost + 3];  // read four at a time
  int of[kMost];
  int count = 0;
};

/// Catmull and Rom's cubic.
BRIM_INLINE float smooth_value(const float* first, std::ptrdiff_t nx, std::ptrdiff_t nxy, float x, float y, float z) {
  const FloatLanes t = {x, y, z, 0.0f}, t2 = t * t, t3 = t2 * t;
  const FloatLanes w0 = 0.5f * (2.0f * t2 - t3 - t), w1 = 0.5f * (3.0f * t3 - 5.0f * t2 + 2.0f),
                   w2 = 0.5f * (4.0f * t2 - 3.0f * t3 + t), w3 = 0.5f * (t3 - t2);
  const FloatLanes wx = {w0[0], w1[0], w2[0], w3[0]};
  const float wy[4] = {w0[1], w1[1], w2[1], w3[1]}, wz[4] = {w0[2], w1[2], w2[2], w3[2]};
  FloatLanes sum = {};
  for (int m = 0; m < 4; ++m) {
    FloatLanes plane = {};
    for (int l = 0; l < 4; ++l) plane += wy[l] * load_lanes(first + l * nx + m * nxy);
    sum += wz[m] * plane;
  }
  sum *= wx;
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

BRIM_INLINE WideFloats joined(const FloatLanes& a, const FloatLanes& b) {
  return __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7);
}

/// Values at up to four places from p on: along z in all 16 lines of a place, along y in those of all places, and along
/// x; two lines at a time, or two places.
template <int kMost>
BRIM_INLINE FloatLanes kinked_values(const TricubicCells& cells, const KinkedPlaces<kMost>& at, int p) {
  const WideFloats all = WideFloats{} + cells.inverse;
  const std::ptrdiff_t nx = cells.nx;
  WideFloats z[4][2] = {};
  for (int i = 0; i < 4 && p + i < at.count; ++i)
    for (int half = 0; half < 2; ++half) {
      WideFloats plane[4];
      for (int m = 0; m < 4; ++m) {
        const float* line = at.first[p + i] + 2 * half * nx + m * cells.nxy;
        plane[m] = joined(load_lanes(line), load_lanes(line + nx));
      }
      z[i][half] = kinked_cubic(plane[0], plane[1], plane[2], plane[3], WideFloats{} + at.z[p + i], all);
    }
  const FloatLanes ty = load_lanes(at.y + p), tx = load_lanes(at.x + p);
  const auto along_y = [&](const WideFloats(&a)[2], const WideFloats(&b)[2], const WideFloats& t) BRIM_LAMBDA_INLINE {
    const auto lower = [&](int half) BRIM_LAMBDA_INLINE {
      return WideFloats(__builtin_shufflevector(a[half], b[half], 0, 1, 2, 3, 8, 9, 10, 11));
    };
    const auto upper = [&](int half) BRIM_LAMBDA_INLINE {
      return WideFloats(__builtin_shufflevector(a[half], b[half], 4, 5, 6, 7, 12, 13, 14, 15));
    };
    return kinked_cubic(lower(0), upper(0), lower(1), upper(1), t, all);
  };
  // Four numbers along x of each place.
  const WideFloats y0 = along_y(z[0], z[1], __builtin_shufflevector(ty, ty, 0, 0, 0, 0, 1, 1, 1, 1)),
                   y1 = along_y(z[2], z[3], __builtin_shufflevector(ty, ty, 2, 2, 2, 2, 3, 3, 3, 3));
  return kinked_cubic(FloatLanes(__builtin_shufflevector(y0, y1, 0, 4, 8, 12)),
                      FloatLanes(__builtin_shufflevector(y0, y1, 1, 5, 9, 13)),
                      FloatLanes(__builtin_shufflevector(y0, y1, 2, 6, 10, 14)),
                      FloatLanes(__builtin_shufflevector(y0, y1, 3, 7, 11, 15)), tx, FloatLanes{} + cells.inverse);
}

/// Values at the places of every bit i < kMost of `wanted`.
/// @param place  place(i, x): its coordinates x[3], [spacings] from the first node
/// @return the bits of places in no inner cell or in an exact one, whose values are not written
template <int kMost, class Bits, class Place>
BRIM_INLINE Bits values_at(const TricubicCells& cells, Bits wanted, const Place& place, float* out) {
  Bits left = 0;
  KinkedPlaces<kMost> kinked;
  for (int i = 0; i < kMost; ++i) {
    const auto bit = static_cast<Bits>(Bits{1} << i);
    if (!(wanted & bit)) continue;
    double x[3];
    place(i, x);
    if (!(x[0] >= 1.0 && x[1] >= 1.0 && x[2] >= 1.0 && x[0] < cells.last[0] && x[1] < cells.last[1] &&
          x[2] < cells.last[2])) {
      left |= bit;
      continue;
    }
    const auto cx = static_cast<std::ptrdiff_t>(x[0]), cy = static_cast<std::ptrdiff_t>(x[1]),
               cz = static_cast<std::ptrdiff_t>(x[2]);
    const std::ptrdiff_t node = cx + cells.nx * cy + cells.nxy * cz;
    const float* first = cells.values + node - 1 - cells.nx - cells.nxy;
    const auto tx = static_cast<float>(x[0] - static_cast<double>(cx)),
               ty = static_cast<float>(x[1] - static_cast<double>(cy)),
               tz = static_cast<float>(x[2] - static_cast<double>(cz));
    if (!KinkedCells::holds(cells.kinks, static_cast<std::size_t>(node))) {
      out[i] = smooth_value(first, cells.nx, cells.nxy, tx, ty, tz);
      continue;
    }
    if (cells.exact != nullptr && KinkedCells::holds(cells.exact, static_cast<std::size_t>(node))) {
      left |= bit;
      continue;
    }
    const int n = kinked.count++;
    kinked.first[n] = first, kinked.x[n] = tx, kinked.y[n] = ty, kinked.z[n] = tz, kinked.of[n] = i;
  }
  for (int n = kinked.count; n < kinked.count + 3; ++n) kinked.x[n] = kinked.y[n] = kinked.z[n] = 0.0f;
  for (int p = 0; p < kinked.count; p += 4) {
    const FloatLanes value = kinked_values(cells, kinked, p);
    for (int i = 0; i < 4 && p + i < kinked.count; ++i) out[kinked.of[p + i]] = value[i];
  }
  return left;
}

}  // namespace tricubic

}  // namespace brim
