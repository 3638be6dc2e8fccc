#pragma once

#include <span>
#include <vector>

#include "brim/body/grid_fluid/grid_poisson.h"
#include "brim/body/grid_fluid/mac_grid.h"
#include "brim/body/grid_fluid/wet_faces.h"

namespace brim {

/// Takes out of a field of impulses what a pressure can resist, so that no wet cell gains or loses volume:
///   z = M⁻¹ (r + Dᵀ π),   D z = 0   =>   D M⁻¹ Dᵀ π = −D M⁻¹ r
/// with π the impulse of the pressure [Pa s], zero in dry cells, D the flow out of each wet cell [m³/s] and M any
/// positive mass per free face: the inverse of M among the velocities that keep volume, symmetric and positive there.
class PressureProjection {
 public:
  /// @param mass  [kg] per face, > 0 on free faces
  void prepare(const MacGrid& grid, const WetFaces& wet, std::span<const double> mass);
  /// @param r          [N s] per face; only free faces count
  /// @param tolerance  of the flow that remains out of a cell, over that which the first guess of the pressure leaves:
  ///                   within a solve, whose right-hand sides shrink while the pressure in them stays, the answers
  ///                   become exact as they become small
  /// @param z          [m/s], overwritten, zero on all others
  /// @param pressure   π, [Pa s] per cell: first guess, then solution
  /// @return number of iterations
  int project(std::span<const double> r, double tolerance, std::span<double> z, std::span<double> pressure);
  /// What the closed sides of the box push with, [N s]. @param pressure  π, [Pa s] per cell
  Vec3 wall_impulse(std::span<const double> pressure) const;
  /// Largest flow out of a wet cell, [m³/s].
  double divergence(std::span<const double> u) const;

 private:
  void flow(std::span<const double> u, std::span<double> out) const;
  /// z += M⁻¹ Dᵀ π
  void add_push(std::span<const double> pressure, std::span<double> z) const;

  const MacGrid* grid_ = nullptr;
  const WetFaces* wet_ = nullptr;
  std::vector<double> inverse_mass_;  ///< [1/kg], 0 on faces that do not move
  std::vector<double> flow_, change_;
  GridPoisson poisson_;
};

}  // namespace brim
