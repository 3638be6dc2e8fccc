#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "brim/math/types.h"

namespace brim {

/// One step of projected Gauss-Seidel at a contact of Coulomb friction. Vectors are (n, t1, t2).
/// Where the contact then sticks, all three impulses are found at once, λ − W⁻¹ u; otherwise the normal one first, then
/// the tangents, projected to the disc |λ_t| <= μ λ_n.
/// @param W, inverse  [1/kg] response of u to λ, and its inverse, zero where W is singular
/// @param u           [m/s] velocity less its target, at the impulse λ
/// @return the new impulse, [N s]
inline Vec3 relax_contact(const Mat3& W, const Mat3& inverse, double friction, const Vec3& u, const Vec3& impulse) {
  if (friction > 0.0 && inverse(0, 0) > 0.0) {
    const Vec3 next = impulse - inverse * u;
    const double most = friction * next.x();
    if (next.x() >= 0.0 && next.y() * next.y() + next.z() * next.z() <= most * most) return next;
  }
  Vec3 next = impulse;
  next.x() = std::max(0.0, impulse.x() - u.x() / W(0, 0));
  const double most = friction * next.x(), stiff = W(1, 1) + W(2, 2);
  if (most > 0.0 && stiff > 0.0) {
    const double change = next.x() - impulse.x();
    next.y() -= (u.y() + W(1, 0) * change) / stiff;
    next.z() -= (u.z() + W(2, 0) * change) / stiff;
    const double length = std::sqrt(next.y() * next.y() + next.z() * next.z());
    if (length > most) next.y() *= most / length, next.z() *= most / length;
  } else {
    next.y() = next.z() = 0.0;
  }
  return next;
}

/// Inverse of a response matrix of a contact, or zero where it is singular.
inline Mat3 invert_response(const Mat3& W) {
  const double scale = W.trace() / 3.0;
  const bool regular = scale > 0.0 && W.determinant() > 1e-9 * scale * scale * scale;
  return regular ? Mat3(W.inverse()) : Mat3::Zero();
}

}  // namespace brim
