#pragma once

#include "brim/contact/stencil.h"

namespace brim {

/// What contacts at the nodes of a row of a cube take of one side, as ContactSet keeps it.
struct SideRow {
  alignas(32) float gradient[3][kCubeSize];  ///< [1/m] ∇ρ
  alignas(32) float bend[3][kCubeSize];      ///< [1/m²] T H T, packed: uu, uv, vv (unpack_tangent_tensor)
};

/// Eight nodes at a time; where there is no gradient the bend is none.
/// @param rho        derivatives of the densities, at unit step
/// @param told       those of the distances, or none: then the gradient is as long as the densities say, and points and
///                   bends as the distances do
/// @param inverse_h  [1/m]
/// Tests: tests/contact/side_row_test.cpp
void side_row(const RowDerivatives& rho, const RowDerivatives* told, float inverse_h, SideRow& out);

}  // namespace brim
