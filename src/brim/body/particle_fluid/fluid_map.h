#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "brim/core/workspace_pool.h"
#include "brim/map/map.h"
#include "brim/map/row_transpose.h"

namespace brim {

/// Map of a part whose density is a sum of kernels, ρ_j = Σ_p V_p W(r_j − x_p). With u = ∇ρ/|∇ρ| at the node,
///   J v = u Σ_p a_p · v_p + (I − u uᵀ) Σ_p w_p v_p,    a_p = V_p ∇W_jp / g + (1 − |∇ρ|/g) w_p u
/// g = max(|∇ρ|, least slope), w_p kernel weights, Σ w = 1
/// Along u the velocity is the rate of the density itself, so that a penalty force on the density is the exact gradient
/// of its energy, particle by particle; Σ a_p = u, so uniform motion is reproduced and linear momentum is exact.
/// Angular momentum is not: Σ x_p × (Jᵀ f)_p differs from r × f when particles lie unevenly about the node.
///
/// Values and slopes of the kernel are stored in single precision and divided by their own sums in double: both
/// identities hold to rounding, and a product reads a third of the memory. Products are parallel and give the same bits
/// for any number of threads.  Tests: tests/body/fluid_map_test.cpp
class FluidMap final : public Map {
 public:
  /// A particle near a point.
  struct Entry {
    std::int32_t particle;
    float value;  ///< V W, [-]
    float slope;  ///< V W'/r, [1/m²]: its gradient is slope (node − x)
  };
  /// Data shared by the entries of a point.
  struct Row {
    Vec3 node;       ///< [m]
    Vec3 direction;  ///< u, unit
    double share;    ///< 1 / Σ value
    double steep;    ///< 1 / g, [m]
    double rest;     ///< 1 − |∇ρ|/g
  };

  /// @param x        positions of the particles, [m]; shared, must not change
  /// @param entries  of consecutive points, block by block @param length  entries of each point, shape (points)
  void assign(std::shared_ptr<const std::vector<Vec3>> x, std::vector<Row> rows,
              std::span<const std::vector<Entry>> entries, std::span<const std::int32_t> length);

  std::size_t points() const override { return row_.size(); }
  bool select(std::span<const std::uint32_t> rows, std::unique_ptr<Map>& out) const override;
  void apply(std::span<const double> v, std::span<Vec3> u) const override;
  void apply_transpose(std::span<const Vec3> f, std::span<double> Q) const override;
  void add_block_diagonal(std::span<const Mat3> K, std::size_t first, BlockDiagonal& D) const override;

 private:
  /// The entries sorted by particle, built on first use: many maps only give velocities.
  struct ByParticle {
    std::mutex making;
    std::atomic<bool> made = false;
    std::vector<std::int32_t> column;  ///< particle of each entry
    std::vector<Entry> entry;          ///< by particle; `particle` is the point
    RowTranspose transpose;
  };
  /// Force of a point on its entries: value · even + slope · along (node − x).
  struct Push {
    Vec3 even, node;
    double along;
  };
  const ByParticle& by_particle() const;

  std::shared_ptr<const std::vector<Vec3>> x_;
  std::vector<std::int32_t> row_start_;
  std::vector<Row> row_;
  std::vector<Entry> entry_;  ///< by point
  mutable ByParticle by_particle_;
  mutable WorkspacePool<std::vector<Push>> pushes_;
};

}  // namespace brim
