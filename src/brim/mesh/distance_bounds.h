#pragma once

#include <cstdint>

#include "brim/core/simd.h"
#include "brim/mesh/distance_grid.h"

namespace brim {

/// Bounds of a sampled distance from the nearest node, at eight points at once, in spacings. With Lipschitz constant 1,
/// d(node) − e <= d(x) <= d(node) + e, e: distance of the node plus the error of the grid's values. One load per point,
/// where interpolation takes 8 or 64. Outside the grid the lower bound is sqrt(|x−q|² + max(0, d(q) − e)²), q the
/// nearest point of the grid's box. Tests: tests/mesh/distance_row_test.cpp
class DistanceBounds {
 public:
  explicit DistanceBounds(const DistanceGrid& grid)
      : values_(grid.values().data()), inverse_(static_cast<float>(grid.inverse_spacing())) {
    const Vec3i& n = grid.nodes();
    for (int k = 0; k < 3; ++k) last_[k] = static_cast<float>(n[k] - 1);
    nx_ = n.x(), nxy_ = n.x() * n.y();
  }

  struct Range {
    WideFloats least, most;
  };
  /// @param x, y, z  in spacings from the first node
  BRIM_INLINE Range at(const WideFloats& x, const WideFloats& y, const WideFloats& z) const {
    const WideFloats qx = clamped(x, last_[0]), qy = clamped(y, last_[1]), qz = clamped(z, last_[2]);
    const WideIds i = __builtin_convertvector(qx + 0.5f, WideIds), j = __builtin_convertvector(qy + 0.5f, WideIds),
                  k = __builtin_convertvector(qz + 0.5f, WideIds);
    const WideIds node = i + nx_ * j + nxy_ * k;
    WideFloats d;
    for (int l = 0; l < kWideLanes; ++l) d[l] = values_[node[l]];
    d *= inverse_;
    const WideFloats tx = qx - __builtin_convertvector(i, WideFloats), ty = qy - __builtin_convertvector(j, WideFloats),
                     tz = qz - __builtin_convertvector(k, WideFloats);
    // |t| <= (|t|² / c + c) / 2, exact where |t| = c: avoids a square root.
    constexpr float kUsual = 0.55f;
    const WideFloats size = d < 0.0f ? -d : d, beyond = size - static_cast<float>(kExactBand);
    const WideFloats off = (0.5f / kUsual) * (tx * tx + ty * ty + tz * tz) +
                           (0.5f * kUsual + static_cast<float>(kWaviness)) +
                           static_cast<float>(kTooFar) * (beyond > 0.0f ? beyond : WideFloats{});
    Range r{d - off, d + off};
    const WideFloats ax = x - qx, ay = y - qy, az = z - qz, outside2 = ax * ax + ay * ay + az * az;
    for (int l = 0; l < kWideLanes; ++l) {
      if (!(outside2[l] > 0.0f)) continue;
      const float positive = r.least[l] > 0.0f ? r.least[l] : 0.0f;
      r.least[l] = __builtin_sqrtf(outside2[l] + positive * positive);
      r.most[l] += __builtin_sqrtf(outside2[l]);
    }
    return r;
  }

  /// [spacings] error of tricubic interpolation; exact band of a grid; relative excess of a sample beyond it. Samples
  /// may be too large by 2 % of their whole value (make_distance_grid): kWaviness covers the excess over that, at most
  /// 0.08 spacings.
  static constexpr double kWaviness = 0.5, kExactBand = 4.0, kTooFar = 0.025;

 private:
  static BRIM_INLINE WideFloats clamped(const WideFloats& x, float last) {
    const WideFloats up = x > 0.0f ? x : WideFloats{};
    return up < last ? up : WideFloats{} + last;
  }

  const float* values_;
  float inverse_;
  float last_[3];
  std::int32_t nx_, nxy_;
};

}  // namespace brim
