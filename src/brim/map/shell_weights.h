#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "brim/map/lever_weights.h"

namespace brim {

/// Map of sheets: a point rides on a triangle x_0 x_1 x_2 with unit normal n, at a distance d from its plane,
///   r = Σ b_i x_i + d n(x),   b, d constant
///   ∂n = − Σ ∇b_i (n · ∂x_i),   ∇b_i: gradient of b_i in the plane of the triangle
///   J_i = b_i I − d ∇b_i nᵀ,     J_iᵀ f = b_i f − d n (∇b_i · f)
/// Σ J_i = I and Σ x_i × J_iᵀ f = r × f, so linear and angular momentum of contact are exact also for points off the
/// middle surface. J changes with q; the geometric term is left out (it is not definite and contact forces are small
/// against the stiffness of the sheet).
/// Tests: tests/map/shell_weights_test.cpp
class ShellWeightsMap final : public LeverWeightsMap {
 public:
  /// @param particles  number of particles of the body, nv / 3
  void reset(std::size_t particles, std::size_t points) { LeverWeightsMap::reset(particles, points, 3); }
  /// Lets point p at r ride on a triangle. Weights extrapolate linearly where r projects outside of the triangle, until
  /// Σ|b| passes kMaxWeight; there (slivers, far points) b becomes that of the closest point and d = 0, and the torque
  /// of a force at r does not arrive whole. May run in parallel for different p. @param x  positions of the particles,
  /// [m], shape (particles)
  void set(std::size_t p, const Vec3& r, const std::array<std::int32_t, 3>& triangle, std::span<const Vec3> x);

  /// Largest Σ|b| for which weights are extrapolated.
  static constexpr double kMaxWeight = 8.0;
  /// Σ|b| of r in the plane of a triangle; infinite where the triangle has no area.
  static double weight_sum(const Vec3& r, const std::array<std::int32_t, 3>& triangle, std::span<const Vec3> x);
};

}  // namespace brim
