#pragma once

#include <span>

#include "brim/contact/contact_set.h"
#include "brim/contact/cube_contacts.h"

namespace brim {

/// True for two surfaces that are bent and lie along each other: a shaft in its bore, a nut on its bolt. Over all
/// contacts of the pair, the curvature of the gap is small next to those of the surfaces,
///   Σ |H_a + H_b| < 0.68 Σ (|H_a| + |H_b|)
/// H: curvature tensors of the densities. Flat and convex contacts have a ratio of 1, a ball in a bowl of ten times its
/// radius 0.8, a thread 0.5 to 0.6, shafts of 6 to 8 voxels with a play of 0.1 to 0.6 voxels 0.57: most of it is the
/// ends.
bool fit_each_other(const ContactSet& contacts, const ContactPair& pair);

/// The rigid motion of a solid through a step, by its velocities.
struct SolidMotion {
  Vec3 center = Vec3::Zero(), velocity = Vec3::Zero();  ///< [m], [m/s] a point, and its velocity
  Vec3 spin = Vec3::Zero();                             ///< [rad/s]
  Pose after(const Pose& now, double dt) const;
};

/// The motion that gives the material of a rigid part these velocities, about the point that moves with its mean
/// velocity.
/// @param points  [m] not all on one line  @param velocities  [m/s]  @param mean_velocity  [m/s] of the whole part
SolidMotion rigid_motion_of(std::span<const Vec3> points, std::span<const Vec3> velocities, const Vec3& mean_velocity);

/// Sets the rates at which the overlap of two solids falls, −Δρ̄/dt, [1/s], from the motion of the solids themselves:
/// the overlap at each node now, and where the patch carries the node, in the poses at the end of the step. A body that
/// spins in a surface that fits it moves along the surface by a large part of a voxel in a step, and rates by
/// velocities along the normals would foretell overlaps which do not come: their forces drove a wheel on its shaft from
/// 5 to 59 rad/s in a second.
/// @param motion_a, motion_b  of the solids  @param patch  [m/s] velocity of the patch  @param dt  [s]
/// @param rate  shape (contacts of the pair)
/// Tests: tests/response/fitting_solids_test.cpp
void set_rates_by_motion(const ContactSet& contacts, const ContactPair& pair, const CubeSide& a, const CubeSide& b,
                         const SolidMotion& motion_a, const SolidMotion& motion_b, const Vec3& patch, double dt,
                         std::span<double> rate);

}  // namespace brim
