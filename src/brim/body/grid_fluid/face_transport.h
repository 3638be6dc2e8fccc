#pragma once

#include <span>
#include <vector>

#include "brim/body/grid_fluid/mac_grid.h"
#include "brim/body/grid_fluid/wet_faces.h"

namespace brim {

/// Scratch of extend_velocity, kept between calls.
struct ExtensionMarks {
  std::vector<unsigned char> known, next;
};

/// Extends face velocities beyond the surface layer by layer: each dry face gets the mean of its known neighbours of
/// the same axis. Faces beyond the layers and on closed sides are zero.
void extend_velocity(const MacGrid& grid, const WetFaces& wet, const std::array<bool, 6>& open, int layers,
                     std::span<double> u, ExtensionMarks& marks);

/// Advects a velocity field by itself for a time dt with the MacCormack scheme (Selle et al. 2008): a semi-Lagrangian
/// step forth and back estimates the error of the first; the result is limited to the range of the samples used. Second
/// order in space and time where the field is smooth.
/// @param u     extended beyond the surface
/// @param mass  [kg] per face: faces without mass stay zero
/// @param out   shape (faces)
void advect_velocity(const MacGrid& grid, std::span<const double> u, std::span<const double> mass, double dt,
                     std::span<double> out);

}  // namespace brim
