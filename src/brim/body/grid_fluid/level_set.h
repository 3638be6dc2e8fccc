#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "brim/body/grid_fluid/mac_grid.h"

namespace brim {

/// Signed distance to the free surface at the centres of a grid's cells, negative inside the fluid (Osher and Sethian
/// 1988). All functions keep their memory in the object; values belong to the caller, shape (cells).
class LevelSet {
 public:
  explicit LevelSet(const MacGrid& grid) : grid_(grid), scratch_(grid.cells()), near_(grid.cells()) {}

  /// ∇φ at a cell by central differences, one-sided at the sides of the box, [-].
  Vec3 gradient(std::span<const double> phi, int i, int j, int k) const;

  /// Restores φ to a distance function without moving its zero: cells next to the surface get φ/|∇φ|, the others solve
  /// the Eikonal equation by fast sweeping (Zhao 2005). O(cells).
  void redistance(std::span<double> phi);

  /// φ ← φ at the material's position a time dt ago (semi-Lagrangian, tricubic). Only within `band` of the surface.
  /// @param velocity  [m/s] of a cell, whose centre is x: Vec3 velocity(int cell, const Vec3& x), called from any
  /// thread
  /// @param open      sides of the box (−x, +x, −y, ...) with air beyond
  template <class Velocity>
  void advect(std::span<double> phi, double dt, double band, const std::array<bool, 6>& open,
              const Velocity& velocity) {
    const Aabb box = grid_.box();
    for_places(grid_.n, [&](int i, int j, int k) {
      const int c = grid_.cell(i, j, k);
      scratch_[c] = phi[c];
      if (std::abs(phi[c]) > band) return;
      const Vec3 center = grid_.cell_center(i, j, k), x = center - dt * velocity(c, center);
      scratch_[c] = cubic(phi, x);
      for (int a = 0; a < 3; ++a) {
        if (open[2 * a]) scratch_[c] = std::max(scratch_[c], box.lo[a] - x[a]);
        if (open[2 * a + 1]) scratch_[c] = std::max(scratch_[c], x[a] - box.hi[a]);
      }
    });
    std::copy(scratch_.begin(), scratch_.end(), phi.begin());
  }

  /// Moves the box. @param origin  [m] its low corner
  void set_origin(const Vec3& origin) { grid_.origin = origin; }

  /// Volume inside, [m³]: each cell near the surface counts with the part behind the plane φ + s + ∇φ·(x − c) = 0.
  /// @param s  [m] added to φ  @param area  [m²] of the surface, −dV/ds
  /// @param left  fraction of each cell not taken by solids, shape (cells); empty: all
  double volume(std::span<const double> phi, double s, double& area, std::span<const double> left = {}) const;
  /// Fluid fraction of a cell, [0, 1].
  double fraction(std::span<const double> phi, int i, int j, int k, double s = 0.0) const;
  /// Fluid fraction of a cell times the offset of the fluid's centre from the cell's centre, [m].
  Vec3 moment(std::span<const double> phi, int i, int j, int k) const;

  /// Moves the surface along its normal, by at most `most`, to the wanted volume.
  /// @return the shift, [m], positive outwards
  double correct_volume(std::span<double> phi, double wanted, double most, std::span<const double> left = {}) const;

 private:
  /// Calls f(fluid fraction, its centre in the cell's own frame [cells]) for each eighth of a cell with fluid.
  template <class F>
  void for_eighths(std::span<const double> phi, int i, int j, int k, double s, const F& f) const;
  void find_near(std::span<const double> phi);
  void sweep(std::span<double> phi) const;
  double cubic(std::span<const double> phi, const Vec3& x) const;

  MacGrid grid_;
  std::vector<double> scratch_;
  std::vector<unsigned char> near_;
};

}  // namespace brim
