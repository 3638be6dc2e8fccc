#pragma once

#include <span>
#include <vector>

#include "brim/body/grid_fluid/mac_grid.h"
#include "brim/body/grid_fluid/wet_faces.h"

namespace brim {

/// Restores the linear momentum of a fluid whose velocities and surface are advected by interpolation, which loses
/// some. It is restored for every connected piece of fluid: a piece is connected through cells that were wet before or
/// are wet after, and all of its faces get the same change of velocity,
///   v_f += (P − Σ m_f v_f)/Σ m_f      along each axis, P the piece's momentum before, m_f after
/// A piece that lost mass loses the corresponding share of P; that share is distributed over all fluid, as its volume
/// is. Advection must not add energy either: if a piece has more than before, its velocities are contracted towards
/// their mean,
///   v_f ← u + s (v_f − u)      u = P/Σ m_f, s² = (E − ½ P·u)/(E' − ½ P·u), E before and E' after
/// All in a fixed order, so the bits are reproducible.  Tests: tests/body/momentum_keeper_test.cpp
class MomentumKeeper {
 public:
  /// Stores the state before. @param mass  [kg] per face, 0 where dry  @param v  [m/s]
  void note(const WetFaces& wet, std::span<const double> mass, std::span<const double> v);
  /// Gives v the stored momentum. @param wet, mass, v  after
  /// @param keep  no fluid can leave: all of its momentum stays
  /// @return momentum of the fluid that left, [N s]
  Vec3 restore(const MacGrid& grid, const WetFaces& wet, std::span<const double> mass, bool keep, std::span<double> v);
  /// The same when the fluid stays and solids appear and disappear: mass lost by faces carries its momentum to faces of
  /// its piece that gain mass, which mix it with their own. Mixing adds no energy. The stored state is that of v.
  void hand_over(const MacGrid& grid, const WetFaces& wet, std::span<const double> mass, std::span<double> v);

 private:
  void label(const MacGrid& grid, const WetFaces& wet);

  void keep_energy(const MacGrid& grid, const WetFaces& wet, std::span<const double> mass, std::span<double> v);

  /// Momentum and mass along each axis, and energy.
  struct Sum {
    Vec3 momentum = Vec3::Zero(), mass = Vec3::Zero();
    double energy = 0.0;
  };
  std::vector<unsigned char> wet_before_;
  std::vector<double> mass_before_, momentum_before_;  ///< per face
  std::vector<std::int32_t> piece_;                    ///< per cell, −1 when always dry
  std::vector<std::int32_t> queue_;
  std::vector<Sum> before_, after_;  ///< per piece
};

}  // namespace brim
