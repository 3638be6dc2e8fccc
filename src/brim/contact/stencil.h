#pragma once

#include <array>

#include "brim/grid/tile.h"
#include "brim/math/types.h"

namespace brim {

/// Weights of the isotropic 3x3x3 stencils at unit step: the derivative along one axis by the central difference,
/// smoothed by (3, 10, 3)/16 along the others (Scharr). Measured isotropy: 0.2 % for a ramp of 3h.
struct Stencil {
  struct Row {
    int offset;                      ///< in a block, from the centre node
    std::array<double, 3> gradient;  ///< x, y, z
    std::array<double, 6> hessian;   ///< xx, yy, zz, xy, xz, yz
  };
  std::array<Row, 27> rows;
};

/// The stencil; constant.
const Stencil& stencil();

/// ∇ρ at a node of a block, [1/m]. @param node  offset of an own node
Vec3 density_gradient(const double* rho, int node, double h);

/// ∇ρ and the second derivatives H of ρ at a node, [1/m] and [1/m²].
void density_derivatives(const double* rho, int node, double h, Vec3& gradient, Mat3& hessian);

}  // namespace brim
