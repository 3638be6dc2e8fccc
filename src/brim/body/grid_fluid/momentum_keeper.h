#pragma once

#include <span>
#include <vector>

#include "brim/body/grid_fluid/mac_grid.h"
#include "brim/body/grid_fluid/wet_faces.h"

namespace brim {

/// Keeps the linear momentum of a fluid whose velocities and surface are carried along by interpolation, which loses
/// some. Every piece of connected fluid keeps its own: a piece is what hangs together in the cells that were wet before
/// or are wet after, and all of its faces get the same change of velocity,
///   v_f += (P − Σ m_f v_f)/Σ m_f      along each axis, P the piece's momentum before, m_f after
/// What a piece has lost in mass takes its share of P along; that goes to all fluid, as its volume does. Nor does being
/// carried along give energy: where a piece would have more than before, its velocities are drawn towards their mean,
///   v_f ← u + s (v_f − u)      u = P/Σ m_f, s² = (E − ½ P·u)/(E' − ½ P·u), E before and E' after
/// All in a fixed order: the same bits always.  Tests: tests/body/momentum_keeper_test.cpp
class MomentumKeeper {
 public:
  /// Notes what there is. @param mass  [kg] per face, 0 where dry  @param v  [m/s]
  void note(const WetFaces& wet, std::span<const double> mass, std::span<const double> v);
  /// Gives v the momentum that was noted. @param wet, mass, v  after
  /// @param keep  no fluid may leave: all of its momentum stays
  /// @return what left with the fluid that did, [N s]
  Vec3 restore(const MacGrid& grid, const WetFaces& wet, std::span<const double> mass, bool keep, std::span<double> v);
  /// The same where fluid stays in its place and solids come and go: mass that faces lose takes its momentum along, to
  /// faces of its piece that gain some, which mix it with their own. So no energy is won, as mixing wins none; what was
  /// noted is that of v.
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
  std::vector<std::int32_t> piece_;                    ///< per cell, −1 where always dry
  std::vector<std::int32_t> queue_;
  std::vector<Sum> before_, after_;  ///< per piece
};

}  // namespace brim
