#pragma once

#include <vector>

#include "brim/map/map.h"
#include "brim/map/map_rows.h"

namespace brim {

/// Map of a rigid part (paper, section 5.3): r' = o' + ω × (r − o), with v = (o', ω) in the world frame.
class RigidMap final : public Map, public SparseMap {
 public:
  /// @param first   row of o' in the body's velocities
  /// @param origin  o, [m]
  void reset(std::size_t first, const Vec3& origin, std::span<const Vec3> points);

  std::size_t points() const override { return arm_.size(); }
  void apply(std::span<const double> v, std::span<Vec3> u) const override;
  void apply_transpose(std::span<const Vec3> f, std::span<double> Q) const override;
  /// Torque of a constant force on a rotating arm: (dθ × (r − o)) × f, the ω × (ω × r) term of section 5.3.
  void add_geometric(std::span<const Vec3> f, std::span<const double> dq, std::span<double> Q) const override;
  bool append_rows(MapRows& out) const override;
  void add_block_diagonal(std::span<const Mat3> K, std::size_t first, BlockDiagonal& D) const override;

 private:
  std::size_t first_ = 0;
  std::vector<Vec3> arm_;  ///< r − o, [m]
};

}  // namespace brim
