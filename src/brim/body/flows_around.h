#pragma once

#include <cstdint>
#include <span>

#include "brim/body/body.h"
#include "brim/body/grid_fluid/mac_grid.h"

namespace brim {

/// Optional interface of fluids on a grid that flow through the space left by solids in its cells (immersed bodies:
/// Batty, Bertails and Bridson 2007). Every wet cell conserves volume,
///   D v = Σ_f ± dx² ((1 − α_f) v_f + Σ_s α_fs (J_s v_s)·e_f) = 0
/// with α_fs the fraction of the cube about face f taken by solid s. The pressure of the common solve pushes fluid and
/// solids, and momentum is exact: D contains both, and Dᵀ gives them opposite impulses.
class FlowsAround {
 public:
  virtual ~FlowsAround() = default;

  virtual const MacGrid& flow_grid() const = 0;
  virtual double flow_density() const = 0;    ///< [kg/m³]
  virtual double flow_viscosity() const = 0;  ///< [Pa s]
  /// False for walls too thin for volume fractions, and for parts that the fluid sticks to: these meet it by contact.
  virtual bool flows_around(const PartInfo& other) const = 0;

  /// Sets the solids, after update.
  /// @param octant  solid fraction of each eighth of a cell, values above 1 count as 1, shape (2 nx, 2 ny, 2 nz), x
  ///                fastest; empty: no solids, and the fluid solves its pressure by itself
  /// @param v       [m/s] of the body: changed to keep its momentum where face masses change; or empty
  virtual void set_solids(std::span<const float> octant, std::span<double> v) = 0;

  /// True while set_solids is valid for the last update.
  virtual bool has_taken_solids() const = 0;

  // ---- of the solve, after prepare_preconditioner; cells that are not wet are ignored
  virtual bool is_wet(int cell) const = 0;
  /// All wet cells, ascending.
  virtual std::span<const std::int32_t> wet_cells() const = 0;
  /// Fluid fraction of face f, [0, 1]; 0 when it is closed.
  virtual double open_share(int face) const = 0;
  /// Share of face f that is fluid free to flow, [0, 1].
  virtual double flowing_share(int face) const = 0;
  /// out_c = D_f u of wet cells, [m³/s]; others are left alone.
  virtual void add_flow(std::span<const double> u, std::span<double> out) const = 0;
  /// impulse += D_fᵀ π. @param pressure  [Pa s] per cell
  virtual void add_push(std::span<const double> pressure, std::span<double> impulse) const = 0;
  /// z = M⁻¹ r of free faces, zero elsewhere.
  virtual void divide_by_mass(std::span<const double> r, std::span<double> z) const = 0;
  /// y = D_f M⁻¹ D_fᵀ x, and z ≈ its inverse times r; symmetric. Values of cells that are not wet are neither read nor
  /// written.
  virtual void apply_poisson(std::span<const double> x, std::span<double> y) = 0;
  virtual void invert_poisson(std::span<const double> r, std::span<double> z) = 0;
  /// Sets the pressure found by the solve, [Pa s] per cell.
  virtual void take_pressure(std::span<const double> pressure) = 0;
};

}  // namespace brim
