#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "brim/mesh/distance.h"

/// How distance grids are filled; used by distance_grid_build.cpp.
namespace brim {

/// Positions of the nodes of a grid.
struct GridLayout {
  Vec3 origin;     ///< [m]
  double spacing;  ///< [m]
  Vec3i nodes;     ///< number along x, y, z

  std::size_t row_count() const { return static_cast<std::size_t>(nodes.y()) * static_cast<std::size_t>(nodes.z()); }
  std::size_t count() const { return row_count() * static_cast<std::size_t>(nodes.x()); }
  Vec3 position(std::size_t row, int i) const {
    const auto ny = static_cast<std::size_t>(nodes.y());
    return origin + spacing * Vec3(i, static_cast<double>(row % ny), static_cast<double>(row / ny));
  }
};

/// Grid that covers the box with at most max_nodes nodes.
/// @throws InputError  when the spacing is not positive or too fine; the message proposes one that fits
GridLayout grid_layout(const Aabb& box, double spacing, std::size_t max_nodes);

/// Value of a node from its closest point: its signed or unsigned distance.
using NodeValue = std::function<float(const Vec3&, const ClosestPoint&)>;

/// Distance to a surface at every node: exact near it, then layer by layer outwards. Each node tries the nearest
/// triangles of its 26 finished neighbours and takes over their sign; a few passes then repeat this over all far nodes.
/// A far node costs O(1), whereas an exact search costs more the farther it is (all triangles of a sphere are nearest
/// to its centre). Far distances are those to some triangle, so never too small; measured up to 2 % too large.
/// @param band  [m] nodes up to this distance are exact; at least 3 spacings, so that no surface lies between a
///              node of a layer and its neighbours
/// @return shape (nz, ny, nx), x fastest.  Same bits for any number of threads.
std::vector<float> spread_distance(const GridLayout& l, const SurfaceTree& tree, double band, const NodeValue& value);

}  // namespace brim
