#pragma once

#include "brim/math/types.h"

namespace brim {

/// Impulse of a contact that jams: what it pushes at cannot move along d, d lies in the cone of friction, and the
/// contact closes along it (a leg almost upright under its hinge, on a platform that rises). No impulse keeps the
/// bodies apart: those along d, of whatever size, move nothing. This is the smallest one in the cone that stops all
/// that impulses can stop; the closing along d remains, as overlap.
///   λ = −W⁺ q + α d,   α >= 0 the smallest with |λ_t| <= μ λ_n
/// It adds no energy: in the range of W the velocity becomes zero, whatever α is.
/// @param W         [1/kg] response of u to λ, singular
/// @param friction  μ > 0
/// @param q         [m/s] velocity minus its target at zero impulse
/// @param along     any impulse whose part without effect has the direction d
/// @return [N s]; W⁺ ignores directions that respond a billionth as much as others, and α ends at a thousand times
///         |W⁺ q|: where d lies at the edge of the cone, to 0.1 % of μ, the contact slips
/// Tests: tests/solve/contact_cone_test.cpp
Vec3 hold_jammed(const Mat3& W, double friction, const Vec3& q, const Vec3& along);

}  // namespace brim
