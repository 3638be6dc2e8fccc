#include "brim/contact/row_ramp.h"

#include <cstring>

#include "brim/core/simd.h"
#include "brim/math/wide_vectors.h"

namespace brim {

BRIM_WIDE void row_ramp_inverse(const float* rho, float w, float* d) {
  const CubeRow zero{}, one = zero + 1.0f;
  CubeRow r;
  std::memcpy(&r, rho, sizeof r);
  r = r < zero ? zero : (r > one ? one : r);
  const CubeRow other = one - r, least = r < other ? r : other, q = least + least;
  CubeRow v = wide_root(q / (6.0f - 4.0f * wide_root(q * (1.0f / 6.0f))));
  for (int step = 0; step < 2; ++step) {
    const CubeRow slope = 12.0f * v * (one - v);
    v -= (v * v * (6.0f - 4.0f * v) - q) / (slope > 1e-20f ? slope : one);
  }
  const CubeRow u = w * (0.5f - v), found = r < other ? u : -u;
  std::memcpy(d, &found, sizeof found);
}

}  // namespace brim
