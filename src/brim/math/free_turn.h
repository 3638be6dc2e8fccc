#pragma once

#include <algorithm>
#include <cmath>

#include "brim/math/rotation.h"
#include "brim/math/types.h"

namespace brim {

/// Torque-free rotation of a body over the time dt: the angular momentum L is constant, the angular velocity is not.
///   R' = ω × R,   ω = R spin_of(Rᵀ L),   R(0) = 1
/// By the fourth-order commutator-free method of Celledoni, Marthinsen and Owren, "Commutator-free Lie group methods"
/// (Future Generation Computer Systems 19, 2003), in pieces of at most 0.05 rad while 32 of them suffice. Exact for a
/// constant angular velocity.
/// @param L        [kg m²/s] about the centre of mass
/// @param spin_of  [rad/s] angular velocity of an angular momentum in the body's axes at the start: I⁻¹ L
/// @param dt       [s] may be negative
template <class SpinOf>
Quat free_turn(const Vec3& L, double dt, const SpinOf& spin_of) {
  constexpr double kAngle = 0.05;
  constexpr double kPieces = 32.0;
  constexpr double kSteady =
      1e-14;  // relative change of the angular velocity over a step below which it counts as constant
  const auto spin = [&](const Quat& r) -> Vec3 { return r * Vec3(spin_of(Vec3(r.conjugate() * L))); };
  const Vec3 first = spin_of(L);
  const Quat straight = rotation_from_vector(dt * first);
  if ((spin(straight) - first).norm() <= kSteady * first.norm()) return straight;
  const double pieces = std::clamp(std::ceil(first.norm() * std::abs(dt) / kAngle), 1.0, kPieces), h = dt / pieces;
  Quat r = Quat::Identity();
  for (int i = 0; i < static_cast<int>(pieces); ++i) {
    const Vec3 k1 = spin(r);
    const Quat half = rotation_from_vector(0.5 * h * k1) * r;
    const Vec3 k2 = spin(half);
    const Vec3 k3 = spin(rotation_from_vector(0.5 * h * k2) * r);
    const Vec3 k4 = spin(rotation_from_vector(h * k3 - 0.5 * h * k1) * half);
    const Vec3 both = 2.0 * (k2 + k3);
    r = rotation_from_vector(h / 12.0 * (both - k1 + 3.0 * k4)) *
        (rotation_from_vector(h / 12.0 * (both + 3.0 * k1 - k4)) * r);
  }
  return r;
}

}  // namespace brim
