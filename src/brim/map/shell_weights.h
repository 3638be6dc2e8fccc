#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "brim/map/lever_weights.h"
#include "brim/map/sheet_patches.h"

namespace brim {

/// Map of sheets: a point attached to a triangle x_0 x_1 x_2 with unit normal n, at a distance d from its plane,
///   r = Σ b_i x_i + d n(x),   b, d constant
///   ∂n = − Σ ∇b_i (n · ∂x_i),   ∇b_i: gradient of b_i in the plane of the triangle
///   J_i = b_i I − d ∇b_i nᵀ,     J_iᵀ f = b_i f − d n (∇b_i · f)
/// Σ J_i = I and Σ x_i × J_iᵀ f = r × f, so linear and angular momentum of contact are exact also for points off the
/// middle surface. J changes with q; the geometric term is neglected (it is not definite, and contact forces are small
/// against the stiffness of the sheet).
///
/// A triangle that is small compared with d, or degenerate, is a short lever: a force at r would move its vertices
/// wildly. There the point is attached to the patch around it, with the same J: n is the direction in which the patch
/// is thinnest, and b, ∇b are those of the linear field that fits the vertices best in the plane perpendicular to n,
///   t_i = x_i − c − n n·(x_i − c),   ∇b_i = (Σ t tᵀ)⁻¹ t_i,   b_i = 1/k + ∇b_i · (r − c),   c = Σ x_i / k
/// for which the same two sums hold, flat patch or not; for three vertices it equals the triangle's own.
/// Tests: tests/map/shell_weights_test.cpp
class ShellWeightsMap final : public LeverWeightsMap {
 public:
  /// @param points    [m] shape (points)
  /// @param triangle  nearest triangle of each point, shape (points)
  /// @param x         positions of the particles of the body, [m], shape (nv / 3)
  void build(const SheetPatches& sheet, std::span<const Vec3> points, std::span<const std::int32_t> triangle,
             std::span<const Vec3> x);

  /// Largest |b_i| + |d ∇b_i| for which a point is attached to its triangle. Beyond three times that the patch is not
  /// used either: b is that of the closest point of the triangle and d = 0, and part of the torque of a force is lost.
  static constexpr double kMaxLever = 3.0;
  /// Weights b of a point over the plane of a triangle, their gradients and its normal n.
  struct PlaneWeights {
    bool has_area = false;  ///< false: the other members are undefined
    Vec3 b, n;
    std::array<Vec3, 3> gradient;
  };
  /// Largest |b_i| + |d ∇b_i| of r on its triangle; infinite when its area is zero.
  static double lever(const Vec3& r, const SheetPatches::Corners& triangle, std::span<const Vec3> x);

 private:
  /// @param d  [m] distance of the point from the plane
  void ride_on_triangle(std::size_t p, const SheetPatches::Corners& triangle, const PlaneWeights& w, double d);
  /// @return false when the patch is too small as well
  bool ride_on_patch(std::size_t p, const Vec3& r, std::span<const std::int32_t> patch, std::span<const Vec3> x);
  void ride_on_closest(std::size_t p, const Vec3& r, const SheetPatches::Corners& triangle, std::span<const Vec3> x);
};

}  // namespace brim
