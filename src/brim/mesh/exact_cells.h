#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "brim/math/types.h"
#include "brim/mesh/distance.h"

namespace brim {

class DistanceGrid;

/// The cells of a sampled distance beside sharp edges and corners of a closed surface, where interpolation is wrong by
/// more than a fiftieth of a spacing: there the distance to the triangles themselves is taken, of those few that are
/// nearest to some place of the cell. (At a corner of three faces interpolation reaches out by a tenth of a spacing,
/// and a solid would lean on it.) Where edges turn by 2 to 30 degrees there are none: round
/// surfaces have such edges between their triangles, and interpolation describes them better.
/// Tests: tests/mesh/exact_cells_test.cpp
class ExactCells {
 public:
  /// Smallest error of interpolation that counts, and farthest distance from the surface, over the spacing.
  static constexpr double kError = 0.02, kFar = 4.0;

  /// @param tree  of the closed, oriented surface that the grid samples
  ExactCells(std::shared_ptr<const SurfaceTree> tree, const DistanceGrid& grid);

  bool empty() const { return triangles_.empty(); }
  /// One bit per cell, at the index of its first node.
  const std::uint32_t* bits() const { return bits_.data(); }
  /// The signed distance, [m], at p in the cell of a node whose bit is set.
  double value(std::size_t node, const Vec3& p) const;

 private:
  ClosestPoint closest(const std::int32_t* triangles, std::size_t count, const Vec3& p) const;
  double distance(const std::int32_t* triangles, std::size_t count, const Vec3& p) const;
  /// Leaves those of the triangles that are nearest to some of 64 places of a cell.
  void keep_nearest(const Vec3& lo, double spacing, std::vector<std::int32_t>& triangles) const;

  std::shared_ptr<const SurfaceTree> tree_;
  std::vector<std::uint32_t> bits_, before_;  ///< before_: cells before those of a word of bits
  std::vector<std::uint32_t> first_;          ///< of each cell's triangles; one more at the end
  std::vector<std::int32_t> triangles_;
};

}  // namespace brim
