#pragma once

#include "brim/core/simd.h"

namespace brim {

/// Interpolates a signed distance between the middle two of four collinear samples, at the fraction t from b to c.
/// Smooth case: the Catmull-Rom cubic, exact for parabolas:
///   b + t (c − b) − t (1 − t)/2 D,   D = (1 − t) L + t R,   L = a − 2 b + c,   R = b − 2 c + d
/// Distances have kinks: inside a solid between two of its faces, outside in concave corners.
/// - Beside a kink the samples beyond it are misleading, and the cubic overshoots by up to 7 % of the kink: bodies
/// would stand on such bumps. So the smaller of L and R gets more weight: weights are divided by level² + bend², as in
/// the schemes of Liu, Osher and Chan (1994).
/// - If the kink lies between b and c, both L and R are large: the value is the larger of the two lines (the smaller,
/// in a concave corner) extrapolated from either side, which meet in the kink. Outside around an edge the distance is
/// round, about half-way between both rules.
/// @param inverse  [1/m] of the spacing
/// Tests: tests/mesh/distance_grid_test.cpp
template <class T>
BRIM_INLINE T kinked_cubic(const T& a, const T& b, const T& c, const T& d, const T& t, const T& inverse) {
  // Bends over the spacing: level of a negligible one; squares of sums from which two form a kink, and the inverse of
  // the range over which that becomes certain; the same for their product. In spacings: inverse of the distance outside
  // over which a kink becomes round, and the depth beyond which it does not matter and samples are rough.
  constexpr float kLevel2 = 0.03f * 0.03f, kKink2 = 0.25f, kSure = 4.0f, kBoth = 100.0f, kRound = 4.0f, kDeep = 4.0f;
  const T nothing{}, one = nothing + 1.0f, s = one - t;
  const auto clamped = [&](const T& x) BRIM_LAMBDA_INLINE {
    const T least = x > nothing ? x : nothing;
    return least < one ? least : one;
  };
  const T left = (a - b) + (c - b), right = (b - c) + (d - c), l = left * inverse, r = right * inverse;
  const T of_left = s * (kLevel2 + r * r), of_right = t * (kLevel2 + l * l);
  const T smooth = b + t * (c - b) - 0.5f * t * s * ((of_left * left + of_right * right) / (of_left + of_right));
  const T sum = l + r, from_left = b + t * (b - a), from_right = c - s * (d - c);
  const T higher = from_left > from_right ? from_left : from_right,
          lower = from_left > from_right ? from_right : from_left;
  // Extrapolated lines below both samples may meet in a ridge or be cut off by a third face.
  const T low = b < c ? b : c, high = b < c ? c : b, ridge = sum > nothing ? higher : lower,
          cut = sum > nothing ? (ridge > low ? ridge : low) : (ridge < high ? ridge : high);
  const T kinked = 0.5f * (ridge + cut), outside = (sum > nothing ? kinked : -kinked) * inverse;
  const T share = clamped(kSure * (sum * sum - kKink2)) * clamped(kBoth * (l * r)) * clamped(kDeep + outside);
  return smooth + share * (one - 0.5f * clamped(kRound * outside)) * (kinked - smooth);
}

}  // namespace brim
