#include "brim/contact/row_ramp.h"

#include <cmath>
#include <cstring>

#include "brim/core/simd.h"

namespace brim {

namespace {

BRIM_INLINE CubeRow row_root(const CubeRow& x) {
  CubeRow r;
  for (int i = 0; i < kCubeSize; ++i) r[i] = std::sqrt(x[i]);
  return r;
}

}  // namespace

BRIM_WIDE void row_ramp_inverse(const float* rho, float w, float* d) {
  const CubeRow zero{}, one = zero + 1.0f;
  CubeRow r;
  std::memcpy(&r, rho, sizeof r);
  r = r < zero ? zero : (r > one ? one : r);
  const CubeRow other = one - r, least = r < other ? r : other, q = least + least;
  CubeRow v = row_root(q / (6.0f - 4.0f * row_root(q * (1.0f / 6.0f))));
  for (int step = 0; step < 2; ++step) {
    const CubeRow slope = 12.0f * v * (one - v);
    v -= (v * v * (6.0f - 4.0f * v) - q) / (slope > 1e-20f ? slope : one);
  }
  const CubeRow u = w * (0.5f - v), found = r < other ? u : -u;
  std::memcpy(d, &found, sizeof found);
}

}  // namespace brim
