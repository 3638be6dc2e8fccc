#pragma once

#include <functional>
#include <span>
#include <vector>

#include "brim/body/meshless/moving_least_squares.h"
#include "brim/math/block_matrix.h"

namespace brim {

/// Frames fixed or moved by a constraint, and the matter that moves with them.
struct HeldRegion {
  std::vector<std::int32_t> frames;
  std::function<bool(const Vec3&)> inside;  ///< of a point at rest, world frame
};

/// Ties matter in held regions to the frames held there, since shape functions of free neighbours do not vanish in the
/// region:
///   E = ½ κ Σ_s V_s |Σ_k χ_k(X_s) q_k|² = −½ Σ_{k<l} c_kl |q_k − q_l|²,   χ = φ − ψ,   c_kl = κ Σ_s V_s χ_k χ_l
/// with φ the shape functions of all frames and ψ those of the region's frames alone. Σ χ = 0 and Σ χ_k X_k = 0: affine
/// motions have no energy, and the forces have no resultant. Regions with fewer than four frames, or all in a plane,
/// hold only their frames.  Tests: tests/body/held_matter_test.cpp
class HeldMatter {
 public:
  HeldMatter() = default;
  /// @param frames   [m] X_k
  /// @param reach    [m] of shape functions
  /// @param points   [m] X_s; one in several regions belongs to the first
  /// @param shape    φ at the points
  /// @param volume   [m³] V_s
  /// @param tension  [Pa/m²] κ
  HeldMatter(std::span<const HeldRegion> regions, std::span<const Vec3> frames, double reach,
             std::span<const Vec3> points, const ShapeFunctions& shape, std::span<const double> volume, double tension);

  /// Adds to the pattern of the stiffness; the caller calls begin and finish.
  void add_pattern(BlockMatrix& matrix) const;
  void find_pairs(const BlockMatrix& matrix);
  void add(std::span<const Vec3> x, std::span<Vec3> force, BlockMatrix& stiffness) const;
  double energy(std::span<const Vec3> x) const;
  std::size_t size() const { return tie_.size(); }

 private:
  struct Tie {
    std::int32_t k, l;       // k < l
    double c;                // [N/m]
    std::int32_t pair = -1;  // slot in the matrix
  };
  std::vector<Tie> tie_;
};

}  // namespace brim
