#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>

#include "brim/math/types.h"

namespace brim {

/// Connected particles, some of them perhaps with prescribed velocities.
struct ParticleSet {
  std::span<const double> mass;              ///< [kg]
  std::span<const std::int32_t> prescribed;  ///< sorted
  /// Share of the largest moment of inertia below which the rotation about an axis is less and less part of the rigid
  /// motion: a line that vibrates has a momentum about itself that as a rotation would be arbitrarily fast.
  double least_inertia = 1e-9;
};

/// Rigid part of the motion of particles, with their angular momentum:
///   v_i = ċ + ω × (x_i − c) + u_i,   I ω = Σ m (x − c) × v,   I = Σ m (|d|² − d dᵀ), d = x − c
/// c is the centre of mass, and Σ m u = 0. With prescribed particles c is one of them, and the rotation must leave the
/// others in place too: if they lie in a line, only rotations about it remain, else none (free is false, ω = 0).
struct MeanMotion {
  bool free = true;
  Vec3 center = Vec3::Zero(), velocity = Vec3::Zero(), spin = Vec3::Zero();  // c, ċ, ω
  Mat3 inertia = Mat3::Zero();                                               // I
  Vec3 momentum = Vec3::Zero();  ///< Σ m (x − c) × (v − ċ), also of u where I ω is not all of it
  std::optional<Vec3> axis;      ///< unit; if only rotations about a line remain
  double least_inertia = 0.0;    ///< ParticleSet's

  /// ω of an angular momentum about c: L / I about axes with at least least_inertia of the largest moment I₃, and
  /// L I / (least_inertia I₃)² about others, zero without inertia.
  Vec3 spin_of(const Vec3& L) const;
  /// u of a particle. @param x, v  [m], [m/s] its own
  Vec3 own(const Vec3& x, const Vec3& v) const { return v - velocity - spin.cross(x - center); }
  /// R of a step at constant angular momentum (free_turn).
  Mat3 turn(double dt) const;
};

/// @param x, v  shape (3 particles)
MeanMotion mean_motion(const ParticleSet& p, std::span<const double> x, std::span<const double> v);

/// Correction of the positions that particles reach in the frame that turns with them.
/// @param x     [m] at the start
/// @param way   [m] dt u
/// @param more  [m] to be added, zero on entry
/// @return false when there is none
using Straighten = std::function<bool(std::span<const double> x, std::span<const double> way, std::span<double> more)>;

/// x ← c + dt ċ + R (d + dt u), R: rotation of the step. A rigid motion causes no stretch, unlike x + dt v.
/// @param straighten  null: no correction
/// Tests: tests/body/spin_test.cpp
void advance_turning(const ParticleSet& p, double dt, std::span<double> x, std::span<const double> v,
                     const Straighten& straighten = {});

/// Q += m δv / dt, change of the velocities in the frame that rotates with the particles, without forces:
///   δv = (Rᵀ − 1) (ω × d) + (Rᵀ² − 1) u, without its own rigid part
/// the centrifugal force and the Coriolis force, which rotates u and does not change |u|.
void add_turning_forces(const ParticleSet& p, double dt, std::span<const double> x, std::span<const double> v,
                        std::span<double> Q);

/// Rotates the velocities with the particles and restores their momentum:
///   v ← v + (t + ω⁺ × d⁺ − ω × d + (R − 1) u),   Σ m d⁺ × v = Σ d × (m v + j),   Σ m v = Σ (m v + j)
/// @param before  [m] x for which v was found
/// @param after   [m] advanced; also moved by dt t
/// @param j       [N s] to be given back, as a rigid motion
void turn_velocities(const ParticleSet& p, double dt, std::span<const double> before, std::span<double> after,
                     std::span<double> v, std::span<const double> j);

/// [J] Kinetic energy of the motion about the centre of mass.
double energy_about_center(std::span<const double> mass, std::span<const double> v);

/// v ← ċ + ω × d + s u, 0 <= s <= 1: energy_about_center is then at most `most`, or that of the rotation alone. Both
/// momenta stay as they are. Tests: tests/body/mean_motion_test.cpp
/// @param p  without prescribed particles
void slow_inner_motion(const ParticleSet& p, std::span<const double> x, double most, std::span<double> v);

}  // namespace brim
