#pragma once

#include <cmath>

#include "brim/core/simd.h"

namespace brim {

/// Eight square roots.
BRIM_INLINE WideFloats wide_root(const WideFloats& x) {
  WideFloats r;
  for (int i = 0; i < kWideLanes; ++i) r[i] = std::sqrt(x[i]);
  return r;
}

/// Eight vectors.
struct WideVectors {
  WideFloats x, y, z;
};
/// Summed in the order in which Eigen sums three products of floats.
BRIM_INLINE WideFloats dot(const WideVectors& a, const WideVectors& b) { return a.x * b.x + (a.y * b.y + a.z * b.z); }
BRIM_INLINE WideFloats length(const WideVectors& a) { return wide_root(dot(a, a)); }
BRIM_INLINE WideVectors operator*(const WideFloats& s, const WideVectors& a) { return {s * a.x, s * a.y, s * a.z}; }
BRIM_INLINE WideVectors operator/(const WideVectors& a, const WideFloats& s) { return {a.x / s, a.y / s, a.z / s}; }

}  // namespace brim
