#pragma once

#include "brim/body/fem/elastic_law.h"

namespace brim::testing {

/// Block K_ij of an element in the principal frame, per unit volume.
/// @param plus, minus  half the sum and half the difference, flip ± twist, of the response
/// @param a, b         gradients g_i, g_j of two shape functions in the frame of V, [1/m]
inline Mat3 principal_block(const PrincipalResponse& r, const Vec3& plus, const Vec3& minus, const Vec3& a,
                            const Vec3& b) {
  const double a0b0 = a[0] * b[0], a1b1 = a[1] * b[1], a2b2 = a[2] * b[2];
  const double a0b1 = a[0] * b[1], a1b0 = a[1] * b[0];
  const double a0b2 = a[0] * b[2], a2b0 = a[2] * b[0];
  const double a1b2 = a[1] * b[2], a2b1 = a[2] * b[1];
  Mat3 k;
  k(0, 0) = r.stretch(0, 0) * a0b0 + plus[2] * a1b1 + plus[1] * a2b2;
  k(1, 1) = r.stretch(1, 1) * a1b1 + plus[2] * a0b0 + plus[0] * a2b2;
  k(2, 2) = r.stretch(2, 2) * a2b2 + plus[1] * a0b0 + plus[0] * a1b1;
  k(0, 1) = r.stretch(0, 1) * a0b1 + minus[2] * a1b0;
  k(1, 0) = r.stretch(1, 0) * a1b0 + minus[2] * a0b1;
  k(0, 2) = r.stretch(0, 2) * a0b2 + minus[1] * a2b0;
  k(2, 0) = r.stretch(2, 0) * a2b0 + minus[1] * a0b2;
  k(1, 2) = r.stretch(1, 2) * a1b2 + minus[0] * a2b1;
  k(2, 1) = r.stretch(2, 1) * a2b1 + minus[0] * a1b2;
  return k;
}

}  // namespace brim::testing
