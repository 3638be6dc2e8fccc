#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "brim/math/types.h"
#include "brim/solve/jammed_contact.h"

namespace brim {

/// One step of projected Gauss-Seidel at a contact with Coulomb friction. Vectors are (n, t1, t2).
/// If the contact then sticks, all three impulses are found at once, λ − W⁻¹ u; otherwise first the normal one, then
/// the tangents, projected to the disc |λ_t| <= μ λ_n.
/// @param W, inverse  [1/kg] response of u to λ, and its inverse, zero where W is singular
/// @param u           [m/s] velocity minus its target, at the impulse λ
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

/// Solves one contact with Coulomb friction alone, all others held fixed: it separates, sticks, or slips with λ_n, λ_t
/// and a rate s > 0 such that u_n = 0, u_t = −s λ_t, |λ_t| = μ λ_n. Under strong coupling of tangents and normal (μ
/// |W_nt| > W_nn) relax_contact, one direction after the other, diverges; this does not.
///   λ_t(s) = −(S + s)⁻¹ (q_t − W_tn q_n / W_nn),   S = W_tt − W_tn W_nt / W_nn,   s by bracketing
/// Where no impulse can do so, because W is singular and friction holds what moves, hold_jammed.
/// Arguments as for relax_contact.
inline Vec3 solve_contact(const Mat3& W, const Mat3& inverse, double friction, const Vec3& u, const Vec3& impulse) {
  constexpr int kMost = 60;
  constexpr double kClose = 1e-13, kLeast = 1e-12, kSlip = 1e-6;
  const Vec3 q = u - W * impulse;  // at zero impulse
  if (!(friction > 0.0)) return {std::max(0.0, -q.x() / W(0, 0)), 0.0, 0.0};
  if (inverse(0, 0) > 0.0) {
    const Vec3 stick = -(inverse * q);
    const double most = friction * stick.x();
    if (stick.x() >= 0.0 && stick.y() * stick.y() + stick.z() * stick.z() <= most * most) return stick;
  }
  if (q.x() >= 0.0) return Vec3::Zero();
  const double nn = W(0, 0), yn = W(1, 0) / nn, zn = W(2, 0) / nn;
  const double yy = std::max(0.0, W(1, 1) - yn * W(0, 1)), zz = std::max(0.0, W(2, 2) - zn * W(0, 2)),
               yz = W(1, 2) - yn * W(0, 2), y = q.y() - yn * q.x(), z = q.z() - zn * q.x();
  Vec3 found;
  const auto miss = [&](double s) {
    const double a = yy + s, b = zz + s, det = a * b - yz * yz;
    found.y() = -(b * y - yz * z) / det, found.z() = -(a * z - yz * y) / det;
    found.x() = -(q.x() + W(0, 1) * found.y() + W(0, 2) * found.z()) / nn;
    return std::sqrt(found.y() * found.y() + found.z() * found.z()) - friction * found.x();
  };
  double lo = kLeast * W.trace(), at_lo = miss(lo);
  if (!(at_lo > 0.0)) {
    // Friction that stops no slip however slow: the contact jams.
    const bool jams = inverse(0, 0) == 0.0 && lo * std::hypot(found.y(), found.z()) > kSlip * q.norm();
    return jams ? hold_jammed(W, friction, q, found) : found;
  }
  double hi = W.trace(), at_hi = miss(hi);
  for (int i = 0; i < kMost && at_hi > 0.0; ++i) lo = hi, at_lo = at_hi, hi *= 8.0, at_hi = miss(hi);
  // Regula falsi, Illinois.
  int side = 0;
  for (int i = 0; i < kMost && at_hi < 0.0; ++i) {
    const double s = std::clamp((lo * at_hi - hi * at_lo) / (at_hi - at_lo), lo, hi), at = miss(s);
    if (std::abs(at) <= kClose * friction * std::abs(found.x())) break;
    if (at > 0.0) {
      lo = s, at_lo = at, at_hi *= side > 0 ? 0.5 : 1.0, side = 1;
    } else {
      hi = s, at_hi = at, at_lo *= side < 0 ? 0.5 : 1.0, side = -1;
    }
    if (!(hi - lo > kClose * hi)) break;
  }
  found.x() = std::max(0.0, found.x());
  const double most = friction * found.x(), length = std::sqrt(found.y() * found.y() + found.z() * found.z());
  if (length > most) found.y() *= most / length, found.z() *= most / length;
  return found;
}

/// The nearest point in the cone |t| <= μ n.
inline Vec3 project_to_cone(const Vec3& x, double friction) {
  const double t = std::hypot(x.y(), x.z());
  if (t <= friction * x.x()) return x;
  if (friction * t <= -x.x()) return Vec3::Zero();
  const double n = (x.x() + friction * t) / (1.0 + friction * friction), share = friction * n / t;
  return {n, share * x.y(), share * x.z()};
}

/// Error of an impulse within its cone as a solution of its contact, as a velocity, [m/s]; zero for a solution:
///   r = w |λ − P(λ − (u + μ |u_t| n) / w)|,   P: projection to the cone (De Saxcé)
/// Under strong coupling of tangents and normal a contact may have several solutions, one slipping and one separating;
/// this evaluates the given one, and does not search for another.
/// @param w  [1/kg] of the contact's response
inline double contact_residual(double w, double friction, const Vec3& u, const Vec3& impulse) {
  Vec3 apart = u;
  apart.x() += friction * std::hypot(u.y(), u.z());
  return w * (impulse - project_to_cone(impulse - apart / w, friction)).cwiseAbs().maxCoeff();
}

/// Inverse of a response matrix of a contact, or zero where it is singular.
inline Mat3 invert_response(const Mat3& W) {
  const double scale = W.trace() / 3.0;
  const bool regular = scale > 0.0 && W.determinant() > 1e-9 * scale * scale * scale;
  return regular ? Mat3(W.inverse()) : Mat3::Zero();
}

}  // namespace brim
