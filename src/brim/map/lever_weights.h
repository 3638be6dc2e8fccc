#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "brim/map/map.h"
#include "brim/map/map_rows.h"
#include "brim/map/row_transpose.h"

namespace brim {

/// Map of points attached to a few particles with an offset along a direction that rotates with them:
///   u_p = Σ_i (w_i v_i + l_i (d · v_i)),   J_i = w_i I + l_i dᵀ,   J_iᵀ f = w_i f + d (l_i · f)
/// with weights w_i and levers l_i [1] per particle and one direction d per point. ShellWeightsMap and LineWeightsMap
/// define w, l and d for triangles and segments.
/// Products are parallel and give the same bits for any number of threads.
class LeverWeightsMap : public Map, public SparseMap {
 public:
  /// Rows are final from here on.
  void finish();

  std::size_t points() const override { return direction_.size(); }
  void apply(std::span<const double> v, std::span<Vec3> u) const override;
  void apply_transpose(std::span<const Vec3> f, std::span<double> Q) const override;
  bool append_rows(MapRows& out) const override;
  bool select(std::span<const std::uint32_t> rows, std::unique_ptr<Map>& out) const override;
  void add_block_diagonal(std::span<const Mat3> K, std::size_t first, BlockDiagonal& D) const override;

 protected:
  /// Allocates. @param particles  number of particles of the body, nv / 3
  void reset(std::size_t particles, std::size_t points, int entries_per_point);
  /// @param row_start  where the entries of each point start, shape (points + 1)
  void reset(std::size_t particles, std::vector<std::int32_t> row_start);

  std::vector<std::int32_t> row_start_;
  std::vector<std::int32_t> particle_;
  std::vector<double> weight_;   // w_i
  std::vector<Vec3> lever_;      // l_i
  std::vector<Vec3> direction_;  // d, per point

 private:
  /// Entry of a row, stored by particle.
  struct Share {
    double weight;
    Vec3 lever;
    std::int32_t row;
  };
  const RowShares<Share>& by_particle() const;

  std::size_t particles_ = 0;
  mutable RowShares<Share> by_particle_;
};

}  // namespace brim
