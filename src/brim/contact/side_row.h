#pragma once

#include "brim/contact/stencil.h"

namespace brim {

/// Gradient and curvature of one side at the nodes of a row of a cube, in the format of ContactSet.
struct SideRow {
  alignas(32) float gradient[3][kCubeSize];  ///< [1/m] ∇ρ
  alignas(32) float bend[3][kCubeSize];      ///< [1/m²] T H T, packed: uu, uv, vv (unpack_tangent_tensor)
};

/// Computes eight nodes at a time; the bend is zero where there is no gradient.
/// @param rho        derivatives of the densities, at unit step
/// @param told       derivatives of the distances, or null. With them the gradient has the length that the densities
///                   give, its direction and bend are those of the distances
/// @param inverse_h  [1/m]
/// Tests: tests/contact/side_row_test.cpp
void side_row(const RowDerivatives& rho, const RowDerivatives* told, float inverse_h, SideRow& out);

}  // namespace brim
