#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "brim/math/types.h"

namespace brim {

/// Particles that hold together, some of them perhaps with prescribed velocities.
struct ParticleSet {
  std::span<const double> mass;              ///< [kg]
  std::span<const std::int32_t> prescribed;  ///< sorted
};

/// The rigid part of the motion of particles, the one with their angular momentum:
///   v_i = ċ + ω × (x_i − c) + u_i,   I ω = Σ m (x − c) × v,   I = Σ m (|d|² − d dᵀ), d = x − c
/// c is the centre of mass, and Σ m u = 0. Where particles are prescribed, c is one of them and the turn must leave the
/// others alone too: those in a line leave the turns about it, more leave none (free is false, ω = 0).
struct MeanMotion {
  bool free = true;
  Vec3 center = Vec3::Zero(), velocity = Vec3::Zero(), spin = Vec3::Zero();  // c, ċ, ω
  Mat3 inertia = Mat3::Zero();                                               // I
  std::optional<Vec3> axis;  ///< unit; where only turns about a line are left

  /// ω of an angular momentum about c; nothing about axes without inertia.
  Vec3 spin_of(const Vec3& L) const;
  /// R of a step with the angular momentum held (free_turn).
  Mat3 turn(double dt) const;
};

/// @param x, v  shape (3 particles)
MeanMotion mean_motion(const ParticleSet& p, std::span<const double> x, std::span<const double> v);

/// x ← c + dt ċ + R (d + dt u), R: the turn of the step. A rigid motion does not stretch, as x + dt v would.
/// Tests: tests/body/spin_test.cpp
void advance_turning(const ParticleSet& p, double dt, std::span<double> x, std::span<const double> v);

/// Q += m δv / dt, what the velocities in the frame that turns with the particles change by when nothing acts:
///   δv = (Rᵀ − 1) (ω × d) + (Rᵀ² − 1) u, without its own rigid part
/// the centrifugal force and that of Coriolis, which turns u and does not change |u|.
void add_turning_forces(const ParticleSet& p, double dt, std::span<const double> x, std::span<const double> v,
                        std::span<double> Q);

/// Turns the velocities with the particles, with the momentum that they should have:
///   v ← v + (t + ω⁺ × d⁺ − ω × d + (R − 1) u),   Σ m d⁺ × v = Σ d × (m v + j),   Σ m v = Σ (m v + j)
/// @param before  [m] x where v was found
/// @param after   [m] advanced; moved by dt t too
/// @param j       [N s] to be given back, as a rigid motion
void turn_velocities(const ParticleSet& p, double dt, std::span<const double> before, std::span<double> after,
                     std::span<double> v, std::span<const double> j);

}  // namespace brim
