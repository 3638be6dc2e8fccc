#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "brim/core/simd.h"

namespace brim {

/// 1 with the sign of x, also of signed zeros.
BRIM_INLINE float unit_with_sign(float x) { return std::copysign(1.0f, x); }
BRIM_INLINE double unit_with_sign(double x) { return std::copysign(1.0, x); }
BRIM_INLINE WideFloats unit_with_sign(const WideFloats& x) {
  const WideIds sign = std::bit_cast<WideIds>(x) & std::int32_t{INT32_MIN};
  return std::bit_cast<WideFloats>(sign | std::bit_cast<std::int32_t>(1.0f));
}

/// Two unit vectors u, v perpendicular to a unit vector (Duff and others 2017, "Building an orthonormal basis,
/// revisited").
/// @tparam Number  float, double or WideFloats: eight frames at once, same bits as one at a time
template <class Number>
struct TangentFrame {
  Number u[3], v[3];
  BRIM_INLINE TangentFrame(const Number& x, const Number& y, const Number& z) {
    const Number sign = unit_with_sign(z), a = -1.0f / (sign + z), b = x * y * a;
    u[0] = 1.0f + sign * x * x * a, u[1] = sign * b, u[2] = -sign * x;
    v[0] = b, v[1] = sign + y * y * a, v[2] = -y;
  }
};

}  // namespace brim
