#pragma once

#include "brim/math/types.h"

namespace brim {

/// Integrals over tetrahedra, which may be signed: of 1 [m³], x [m⁴] and x xᵀ [m⁵].
struct TetMoments {
  double volume = 0.0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();

  /// Adds the tetrahedron a, b, c, d. @param det  [m³] six times its volume
  void add(double det, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    const Vec3 s = a + b + c + d;
    volume += det / 6.0;
    first += det / 24.0 * s;
    second += det / 120.0 *
              (a * a.transpose() + b * b.transpose() + c * c.transpose() + d * d.transpose() + s * s.transpose());
  }
  Vec3 center() const { return first / volume; }
  /// [m²] of places about the center.
  Mat3 variance() const { return second / volume - center() * center().transpose(); }
};

}  // namespace brim
