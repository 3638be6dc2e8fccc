#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "brim/map/lever_weights.h"

namespace brim {

/// Map of lines: a point attached to a segment x_0 x_1 of length L and direction t, with the offset e ⊥ t,
///   r = b_0 x_0 + b_1 x_1 + e,   e rotates with the segment, without spin about t
///   u = Σ b_i v_i − t (e · (v_1 − v_0)) / L
///   J_0 = b_0 I + t eᵀ / L,      J_1 = b_1 I − t eᵀ / L
/// Σ J_i = I, so linear momentum of contact is exact. A line without thickness of its own has no spin about t:
///   Σ x_i × J_iᵀ f = r × f − t (t · (e × f))
/// so angular momentum is exact for forces in the plane of t and e (normal forces, friction along the line); the spin
/// that friction around the line would cause is lost. Rigid motion is reproduced except for that spin. J changes with
/// q; the geometric term is neglected, as for sheets.
/// Tests: tests/map/line_weights_test.cpp
class LineWeightsMap final : public LeverWeightsMap {
 public:
  /// @param particles  number of particles of the body, nv / 3
  void reset(std::size_t particles, std::size_t points) { LeverWeightsMap::reset(particles, points, 2); }
  /// Attaches point p at r to a segment. Weights extrapolate linearly where r projects outside the segment, until Σ|b|
  /// or |e|/L exceeds kMaxWeight; then (short segments, far points) b is that of the closest point and e = 0. May run
  /// in parallel for different p. @param x  positions of the particles, [m], shape (particles)
  void set(std::size_t p, const Vec3& r, const std::array<std::int32_t, 2>& segment, std::span<const Vec3> x);

  /// Largest Σ|b| up to which weights are extrapolated, and largest |e|/L up to which the offset rotates.
  static constexpr double kMaxWeight = 8.0;
};

}  // namespace brim
