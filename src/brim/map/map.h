#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "brim/math/block_diagonal.h"
#include "brim/math/types.h"

namespace brim {

/// The kinematic map of one part at its contact points (paper, section 5.1): J = ∂r/∂q at points r fixed in space. It
/// is linear and constant during a solve. Generalised vectors are numbered within the body, from 0.
class Map {
 public:
  virtual ~Map() = default;

  /// Number of contact points, n.
  virtual std::size_t points() const = 0;

  /// u = J v: velocity of the body's material at each point.
  /// @param v  generalised velocities of the body, shape (nv)
  /// @param u  [m/s], overwritten, shape (n)
  virtual void apply(std::span<const double> v, std::span<Vec3> u) const = 0;

  /// Q += Jᵀ f: generalised forces that do the same work as f.
  /// @param f  [N], shape (n)
  /// @param Q  shape (nv)
  virtual void apply_transpose(std::span<const Vec3> f, std::span<double> Q) const = 0;

  /// Q += (∂Jᵀ/∂q · dq) f with constant f and points that move with the material (appendix B, last term).
  /// Zero for maps that are linear in q. @param dq  displacement in generalised coordinates, shape (nv)
  virtual void add_geometric(std::span<const Vec3> f, std::span<const double> dq, std::span<double> Q) const {
    (void)f, (void)dq, (void)Q;
  }

  /// Makes `out` the map of a subset of the points, reusing the memory of a map of this kind in it.
  /// @param rows  points, ascending @return false when building the map anew is as fast
  virtual bool select(std::span<const std::uint32_t> rows, std::unique_ptr<Map>& out) const {
    (void)rows, (void)out;
    return false;
  }

  /// Adds the diagonal blocks of Jᵀ K J. @param K  symmetric, one per point, shape (n)
  /// @param first  index of the body's first block in D
  virtual void add_block_diagonal(std::span<const Mat3> K, std::size_t first, BlockDiagonal& D) const = 0;
};

}  // namespace brim
