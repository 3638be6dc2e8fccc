#pragma once

#include <span>

#include "brim/body/body.h"
#include "brim/body/grid_fluid/mac_grid.h"

namespace brim {

/// Optional interface of fluids on a grid that flow through what solids leave of its cells (immersed bodies: Batty,
/// Bertails and Bridson 2007). No wet cell gains or loses volume,
///   D v = Σ_f ± dx² ((1 − α_f) v_f + Σ_s α_fs (J_s v_s)·e_f) = 0
/// with α_fs the share of the cube about face f that is solid s. So the pressure of the common solve pushes fluid and
/// solids, and their momentum is exact: D has both, and Dᵀ gives each what the other does not take.
class FlowsAround {
 public:
  virtual ~FlowsAround() = default;

  virtual const MacGrid& flow_grid() const = 0;
  /// False for what is too thin to be seen as a share of cells, and what the fluid sticks to: that meets it by contact.
  virtual bool flows_around(const PartInfo& other) const = 0;

  /// Takes in what solids leave, after update.
  /// @param octant  share that is solid of each eighth of a cell, more than 1 counting as 1, shape (2 nx, 2 ny, 2 nz),
  /// x fastest; empty:
  ///                there are none, and the fluid solves its pressure by itself
  /// @param v       [m/s] of the body: keeps its momentum where masses of faces change; or empty
  virtual void set_solids(std::span<const float> octant, std::span<double> v) = 0;

  /// True while that holds of what the body was updated to.
  virtual bool has_taken_solids() const = 0;

  // ---- of the solve, after prepare_preconditioner; cells that are not wet count for nothing
  virtual bool is_wet(int cell) const = 0;
  /// Share of face f that is fluid, [0, 1]; 0 where it is closed.
  virtual double open_share(int face) const = 0;
  /// out_c = D_f u of wet cells, [m³/s]; others are left alone.
  virtual void add_flow(std::span<const double> u, std::span<double> out) const = 0;
  /// impulse += D_fᵀ π. @param pressure  [Pa s] per cell
  virtual void add_push(std::span<const double> pressure, std::span<double> impulse) const = 0;
  /// z = M⁻¹ r of free faces, zero elsewhere.
  virtual void divide_by_mass(std::span<const double> r, std::span<double> z) const = 0;
  /// y = D_f M⁻¹ D_fᵀ x, and z about its inverse of r; symmetric.
  virtual void apply_poisson(std::span<const double> x, std::span<double> y) = 0;
  virtual void invert_poisson(std::span<const double> r, std::span<double> z) = 0;
  /// Takes the pressure that the solve has found, [Pa s] per cell.
  virtual void take_pressure(std::span<const double> pressure) = 0;
};

}  // namespace brim
