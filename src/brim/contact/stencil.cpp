#include "brim/contact/stencil.h"

#include <cstring>

#include "brim/core/simd.h"

namespace brim {

namespace {

BRIM_INLINE CubeRow load(const float* x) {
  CubeRow r;
  std::memcpy(&r, x, sizeof r);
  return r;
}
BRIM_INLINE void store(const CubeRow& r, float* x) { std::memcpy(x, &r, sizeof r); }
BRIM_INLINE CubeRow smooth(const CubeRow& a, const CubeRow& b, const CubeRow& c) {
  return 0.1875f * (a + c) + 0.625f * b;
}
BRIM_INLINE CubeRow slope(const CubeRow& a, const CubeRow& c) { return 0.5f * (c - a); }
BRIM_INLINE CubeRow bend(const CubeRow& a, const CubeRow& b, const CubeRow& c) { return (a + c) - 2.0f * b; }
/// Each node's neighbours along the row.
BRIM_INLINE CubeRow before(const CubeRow& a) { return __builtin_shufflevector(a, a, 0, 0, 1, 2, 3, 4, 5, 6); }
BRIM_INLINE CubeRow behind(const CubeRow& a) { return __builtin_shufflevector(a, a, 1, 2, 3, 4, 5, 6, 7, 7); }

}  // namespace

BRIM_WIDE void row_derivatives(const float* rho, int j, int k, bool bent, RowDerivatives& out) {
  CubeRow even[3], odd[3], second[3];  // smoothed, differenced and twice differenced along y, at k − 1, k, k + 1
  for (int dz = 0; dz < 3; ++dz) {
    const CubeRow a = load(rho + cube_index(0, j - 1, k + dz - 1)), b = load(rho + cube_index(0, j, k + dz - 1)),
                  c = load(rho + cube_index(0, j + 1, k + dz - 1));
    even[dz] = smooth(a, b, c), odd[dz] = slope(a, c), second[dz] = bend(a, b, c);
  }
  // Smoothed across x, and the slopes along y and z, each smoothed along the other.
  const CubeRow x = smooth(even[0], even[1], even[2]), y = smooth(odd[0], odd[1], odd[2]), z = slope(even[0], even[2]);
  store(slope(before(x), behind(x)), out.gradient[0]);
  store(smooth(before(y), y, behind(y)), out.gradient[1]);
  store(smooth(before(z), z, behind(z)), out.gradient[2]);
  if (!bent) return;
  const CubeRow yy = smooth(second[0], second[1], second[2]), zz = bend(even[0], even[1], even[2]),
                yz = slope(odd[0], odd[2]);
  store(bend(before(x), x, behind(x)), out.hessian[0]);
  store(smooth(before(yy), yy, behind(yy)), out.hessian[1]);
  store(smooth(before(zz), zz, behind(zz)), out.hessian[2]);
  store(slope(before(y), behind(y)), out.hessian[3]);
  store(slope(before(z), behind(z)), out.hessian[4]);
  store(smooth(before(yz), yz, behind(yz)), out.hessian[5]);
}

}  // namespace brim
