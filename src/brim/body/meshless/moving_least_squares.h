#pragma once

#include <span>

#include "brim/map/weight_rows.h"

namespace brim {

/// Shape functions of scattered frames by moving least squares with a linear basis (Belytschko, Lu and Gu 1994):
///   φ_k(X) = p(X)ᵀ A⁻¹ p(X_k) w_k,   A = Σ w_k p(X_k) p(X_k)ᵀ,   p(X) = (1, X),   w_k = (1 − |X − X_k|²/R²)³
/// Σ φ = 1 and Σ φ_k X_k = X for any frames not all in one plane, so every affine motion is reproduced exactly.
struct ShapeFunctions {
  WeightRows rows;             ///< φ, one row per point
  std::vector<Vec3> gradient;  ///< [1/m] ∇φ, per entry
};

/// @param frames  [m] X_k
/// @param reach   [m] R; enlarged point by point when fewer than four frames, or only frames in a plane, are in reach
/// @throws InputError  when all frames lie in one plane
/// Tests: tests/body/carried_body_test.cpp
ShapeFunctions moving_least_squares(std::span<const Vec3> frames, std::span<const Vec3> points, double reach);

}  // namespace brim
