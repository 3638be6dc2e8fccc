#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "brim/body/motion_clusters.h"
#include "brim/math/block_matrix.h"

namespace brim {

/// Particles of a body in clusters of neighbours, each with the particles that share an element with one of its own: an
/// element lies within the hull of its corners, so it is held by the box of the cluster of any of them.
/// Tests: tests/body/node_clusters_test.cpp
class NodeClusters {
 public:
  /// @param rest     [m] positions that tell neighbours
  /// @param pattern  particles of one element are coupled in it
  void build(std::span<const Vec3> rest, const BlockMatrix& pattern);
  /// Appends the bounds of each cluster.
  /// @param x, v   [m], [m/s] of the particles  @param reach  [m] of the matter beyond the particles
  void measure(std::span<const Vec3> x, std::span<const double> v, double reach, std::vector<MotionCluster>& out) const;
  std::size_t size() const { return first_.size() - 1; }

 private:
  std::vector<std::int32_t> first_{0}, node_;
};

}  // namespace brim
