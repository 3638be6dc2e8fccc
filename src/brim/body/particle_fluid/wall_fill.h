#pragma once

#include "brim/body/particle_fluid/fluid_kernel.h"

namespace brim {

/// What a surface takes up of the neighbourhood of a particle, by its signed distance d:
///   λ(d) = a (d₀ − d)²  for d < d₀
/// such that the lattice of rest, cut by a wall half a spacing off its outermost particles, is full and in balance
/// under any uniform pressure p: with w the kernel sum of the plane of particles that the wall replaces, and w' its
/// slope by the distance,
///   λ(s/2) = w(s),     λ'(s/2) = 2 w'(s)
/// The second says that p λ' is what the missing plane would push with, p from either side of each pair (docs). Beyond
/// d₀, some 0.8 spacings, nothing is seen; a lone particle, that fills a third, comes to rest at 0.17 spacings.
/// Tests: tests/body/wall_fill_test.cpp
class WallFill {
 public:
  /// @param spacing  [m] s of the particles @param volume  [m³] of one
  WallFill(const FluidKernel& kernel, double spacing, double volume);

  double reach() const { return reach_; }  ///< d₀, [m]
  /// λ, [-]; slope: dλ/dd, [1/m], at most 0.
  double operator()(double d, double& slope) const {
    const double u = reach_ - d;
    if (!(u > 0.0)) return slope = 0.0;
    slope = -2.0 * scale_ * u;
    return scale_ * u * u;
  }

 private:
  double reach_ = 0.0, scale_ = 0.0;
};

}  // namespace brim
