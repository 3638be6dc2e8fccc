#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "brim/body/grid_fluid/grid_poisson.h"
#include "brim/body/grid_fluid/mac_grid.h"
#include "brim/body/grid_fluid/wet_faces.h"

namespace brim {

/// Removes from a field of impulses the part balanced by a pressure, so that every wet cell conserves its volume:
///   z = M⁻¹ (r + Dᵀ π),   D z = 0   =>   D M⁻¹ Dᵀ π = −D M⁻¹ r
/// with π the impulse of the pressure [Pa s], zero in dry cells, D the flow out of each wet cell [m³/s] and M any
/// positive mass per free face: the inverse of M on volume-conserving velocities, symmetric and positive there.
class PressureProjection {
 public:
  /// @param mass  [kg] per face, > 0 on free faces
  void prepare(const MacGrid& grid, const WetFaces& wet, std::span<const double> mass);
  /// @param r          [N s] per face; only free faces count
  /// @param tolerance  for the remaining flow out of a cell, relative to the flow left by the initial guess of the
  ///                   pressure: within a solve, whose right-hand sides shrink while their pressure stays, results
  ///                   become exact as they become small
  /// @param z          [m/s], overwritten, zero on all others
  /// @param pressure   π, [Pa s] per cell: initial guess, then solution
  /// @return number of iterations
  int project(std::span<const double> r, double tolerance, std::span<double> z, std::span<double> pressure);
  /// Impulse of the closed sides of the box, [N s]. @param pressure  π, [Pa s] per cell
  Vec3 wall_impulse(std::span<const double> pressure) const;
  /// Flow out of each wet cell, D u, [m³/s]; the others are left alone.
  void flow(std::span<const double> u, std::span<double> out) const;
  /// impulse += Dᵀ π. @param pressure  [Pa s] per cell
  void add_push(std::span<const double> pressure, std::span<double> impulse) const;
  /// z = M⁻¹ r of free faces, zero elsewhere.
  void divide_by_mass(std::span<const double> r, std::span<double> z) const;
  GridPoisson& poisson() { return poisson_; }  ///< D M⁻¹ Dᵀ
  /// Largest flow out of a wet cell, [m³/s].
  double divergence(std::span<const double> u) const;

 private:
  /// A free face and the wet cells on its two sides; without one, an index with pressure zero.
  struct Push {
    std::int32_t face, low, high;
    double inverse_mass;  ///< [1/kg]
    double area;          ///< [m²] open area
  };

  const MacGrid* grid_ = nullptr;
  const WetFaces* wet_ = nullptr;
  std::vector<Push> push_;
  std::vector<std::array<std::int32_t, 2>> wet_cell_;  ///< its number, and that of its low face along x
  std::vector<double> known_, flow_, change_;          ///< per cell; of known_ and change_ the last is always 0
  GridPoisson poisson_;
};

}  // namespace brim
