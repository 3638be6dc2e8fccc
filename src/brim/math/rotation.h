#pragma once

#include "brim/math/types.h"

namespace brim {

/// Rotation by |a| radians about a; smooth at zero.
inline Quat rotation_from_vector(const Vec3& a) {
  const double half = 0.5 * a.norm();
  // sin(x)/x by its series where the quotient would lose digits.
  const double s = half < 1e-4 ? 0.5 * (1.0 - half * half / 6.0) : 0.5 * std::sin(half) / half;
  return Quat(std::cos(half), s * a.x(), s * a.y(), s * a.z());
}

/// Rotation vector of a unit quaternion, length in [0, π].
inline Vec3 vector_from_rotation(const Quat& r) {
  const double sign = r.w() < 0.0 ? -1.0 : 1.0;
  const Vec3 im = sign * Vec3(r.x(), r.y(), r.z());
  const double n = im.norm();
  if (n < 1e-12) return 2.0 * im;
  return (2.0 * std::atan2(n, sign * r.w()) / n) * im;
}

}  // namespace brim
