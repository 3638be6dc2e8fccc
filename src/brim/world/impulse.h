#pragma once

#include <optional>
#include <span>
#include <vector>

#include "brim/body/body.h"
#include "brim/world/world_part.h"

namespace brim {

/// Change of a body's velocities by an impulse on its coordinates, at once: Δv = P (P M P)⁻¹ P p, P: the body's filter.
/// Cholesky of a dense matrix for a few coordinates, conjugate gradients (Hestenes and Stiefel 1952) for many, which
/// end where rounding does: lumped masses take as many iterations as different ones were hit.
/// @param p  [N s, N m s] shape (nv)
/// Tests: tests/world/impulse_test.cpp
std::vector<double> velocity_change(const Body& body, std::span<const double> p);

/// What an impulse does to a body.
struct ImpulseEffect {
  Vec3 point;                  ///< [m] where it acts
  std::vector<double> change;  ///< [m/s, rad/s] of the velocities, shape (nv)
};

/// The effect of an impulse [N s] at the body's matter that MatterPoints finds at a point: velocity_change of its image
/// under the transpose of the body's map there. None when the body has no such points.
/// @param parts  of one body, updated  @param q  of the body  @param ramp_voxels  w over h
std::optional<ImpulseEffect> find_impulse_effect(std::span<const WorldPart> parts, double ramp_voxels,
                                                 std::span<const double> q, const Vec3& impulse, const Vec3& point);

}  // namespace brim
