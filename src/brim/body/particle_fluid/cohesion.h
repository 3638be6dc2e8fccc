#pragma once

#include <span>

#include "brim/body/particle_fluid/fluid_pairs.h"
#include "brim/math/types.h"

namespace brim {

/// Surface tension by forces between pairs of particles (form of the force: Akinci, Akinci and Teschner 2013, equation
/// 2), derived from an energy and along the line between the two, so that both momenta are conserved:
///   F_ij = −A c(q) x_ij/r,     q = r/H,  c = q³ (1 − q)³ for q > 1/2;  2 q³ (1 − q)³ − 1/64 below
///   E    = Σ over pairs  A H u(q),     u(q) = −∫ c from q to 1
/// Attractive beyond 0.23 H and repulsive below, so that particles do not clump. A is chosen so that cutting the rest
/// lattice along a lattice plane takes twice the surface tension per area.  Tests: tests/body/cohesion_test.cpp
class Cohesion {
 public:
  /// @param support  [m] H   @param spacing  [m] of the lattice at rest   @param tension  [N/m], >= 0
  Cohesion(double support, double spacing, double tension);
  /// [s] up to which explicit steps are stable: 0.7 of √(ρ spacing³/(2π σ)), about the time of the shortest waves;
  /// infinite without tension. @param density  [kg/m³]
  double longest_step(double density, double spacing) const;

  bool acts() const { return strength_ > 0.0; }
  /// Attraction divided by distance, [N/m]; r > 0
  double pull_over_r(double r) const;
  /// [J] of a pair; 0 for r >= H
  double energy(double r) const;
  /// For all particles, in cell order: y += forces [N]; the energy [J].
  void add_forces(std::span<const Vec3> x, const FluidPairs& pairs, std::span<Vec3> y) const;
  double energy(std::span<const Vec3> x, const FluidPairs& pairs) const;

 private:
  double support_, strength_ = 0.0;  ///< strength: A [N]
  double tension_ = 0.0;             ///< [N/m]
};

}  // namespace brim
