#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "brim/body/grid_fluid/mac_grid.h"
#include "brim/body/idle_velocities.h"

namespace brim {

/// The cells and faces of a grid that hold fluid, and the amount of fluid each face moves.
///   wet cell   φ < 0 at its centre
///   free face  between a wet cell and another cell, or the air beyond an open side; may have a velocity
///   wall face  between a wet cell and a closed side of the box; its velocity is zero
///   share θ    fraction of the distance between two centres that is fluid: 1 between two wet cells, φ_in/(φ_in −
///   φ_out)
///              at the surface, so that the pressure is zero at the surface and not at a centre (Gibou et al. 2002);
///              1/2
///              at sides
///   open       fraction of a face not taken by solids; cells whose faces are all closed are not wet
/// The mass of a face is proportional to its share, θ times open.
struct WetFaces {
  /// Part of a face below which it is closed.
  static constexpr double kLeastOpen = 0.03;
  enum class Kind : unsigned char { Dry, Free, Wall };
  std::vector<unsigned char> cell;  ///< 1 where wet, shape (cells)
  std::vector<Kind> kind;           ///< shape (faces)
  std::vector<double> share;        ///< [-], 0 where dry, shape (faces)
  std::vector<double> open;         ///< [-], shape (faces)
  std::vector<std::int32_t> wet;    ///< the wet cells, ascending
  std::vector<VelocityRange> held;  ///< the faces that are not free, as ranges
  std::vector<VelocityRange> idle;  ///< those of them that are long
  Layers layers;                    ///< those with faces that are not dry
  bool touches_walls = false;       ///< some face is a wall face

  /// @param open  sides −x, +x, −y, +y, −z, +z with air beyond
  /// @param left  fraction of a face not taken by solids, shape (faces); empty: all
  void find(const MacGrid& grid, std::span<const double> phi, const std::array<bool, 6>& open,
            std::span<const double> left = {});
};

}  // namespace brim
