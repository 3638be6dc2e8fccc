#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "brim/body/particles/element_schedule.h"
#include "brim/math/block_matrix.h"

namespace brim {

/// A spring between two particles.
struct Spring {
  std::array<std::int32_t, 2> node;
  double stiffness;  ///< k [N/m], >= 0
  double length;     ///< L at rest [m], > 0
};

/// Springs between pairs of particles, l the length and n the direction of a spring:
///   E = Σ ½ k (l − L)²,   f_1 = −f_0 = −k (l − L) n
///   K = k [ n nᵀ + max(0, 1 − L/l) (I − n nᵀ) ],   damper: k n nᵀ
/// K is exact in tension; under compression its negative transverse part is dropped, so that it is always positive
/// semi-definite (Baraff and Witkin 1998; Choi and Ko 2002). The damper acts only along the spring and does not brake
/// rotation. A slack spring (strings, ropes) has no energy when shorter than L. A spring of length zero has no
/// direction and gives no force.
class SpringElements {
 public:
  SpringElements() = default;
  /// @param x      positions of the particles, [m], to find neighbours
  /// @param slack  true: resist stretch only
  SpringElements(std::span<const Spring> springs, std::span<const Vec3> x, bool slack = false);

  void find_pairs(const BlockMatrix& matrix);
  /// force += −∂E/∂x, stiffness += K, damper += k n nᵀ; the last two have the same pattern. Parallel, same bits for any
  /// number of threads.
  void add(std::span<const Vec3> x, std::span<Vec3> force, BlockMatrix& stiffness, BlockMatrix& damper) const;
  /// Forces of what springs have become longer by turning: a way across the springs stretches them in second order.
  /// @param x     [m] at the start; forces are along the springs there
  /// @param way   [m] by which the solve has moved the particles
  /// @param more  [m] moved in addition
  /// @param force  [N] added to
  /// @return [J] energy of these lengths
  double add_turned(std::span<const double> x, std::span<const double> way, std::span<const double> more,
                    std::span<double> force) const;
  /// E, [J].
  double energy(std::span<const Vec3> x) const;

  std::size_t size() const { return spring_.size(); }
  /// By place in the order of evaluation.
  std::span<const Spring> springs() const { return spring_; }
  /// Ends of all springs in order of evaluation, shape (2 size).
  const std::vector<std::int32_t>& nodes() const { return node_; }

 private:
  bool slack_ = false;
  ElementSchedule schedule_;
  std::vector<Spring> spring_;
  std::vector<std::int32_t> node_;
  std::vector<std::int32_t> pair_;  // slots of the ends in the matrix
};

}  // namespace brim
