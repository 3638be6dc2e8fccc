#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "brim/math/types.h"

namespace brim {

/// The cells of a sampled distance that a kink may affect: those where one of the 64 surrounding nodes has a bend,
/// along some axis, above a fraction of the spacing. Elsewhere the distance is a smooth cubic.
/// Tests: tests/mesh/distance_grid_test.cpp
class KinkedCells {
 public:
  /// Smallest bend that counts, over the spacing: that of a ball of five spacings. Below it the cubic and kinked_cubic
  /// differ by at most 0.015 spacings.
  static constexpr double kBend = 0.2;

  KinkedCells() = default;
  /// @param values  [m] shape (nz, ny, nx), x fastest
  KinkedCells(const std::vector<float>& values, const Vec3i& nodes, double spacing);
  /// One bit per cell, at the index of its first node.
  const std::uint32_t* bits() const { return bits_.data(); }
  static bool holds(const std::uint32_t* bits, std::size_t node) { return (bits[node >> 5] >> (node & 31) & 1) != 0; }

 private:
  std::vector<std::uint32_t> bits_;
};

}  // namespace brim
