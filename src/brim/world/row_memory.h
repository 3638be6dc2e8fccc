#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "brim/contact/contact_set.h"
#include "brim/math/types.h"

namespace brim {

/// Stores the points of constraint rows from step to step: parts, position and force on a, so that the next step starts
/// from the last impulses. Plain numbers, as they are part of the world's state.
/// Tests: tests/world/row_memory_test.cpp
class RowMemory {
 public:
  /// Force on a of the nearest point of the same pair in the last step, within two voxels and each used once, or zero;
  /// where no point of a pair has one, they share its force: on a round face that spins all are others in each step.
  /// Shape (points).
  void recall(std::span<const double> memory, const ContactSet& points, std::span<Vec3> force);
  /// True when points of pair p shared forces in the last recall().
  bool shared(std::size_t p) const { return anew_[p] != 0; }
  /// The pairs of parts that have points, in order.
  static std::vector<std::pair<std::int32_t, std::int32_t>> pairs(std::span<const double> memory);
  /// Appends a point. @param force  [N] on a
  static void keep(const ContactPair& pair, const Vec3& point, const Vec3& force, std::vector<double>& memory);

 private:
  std::vector<std::uint8_t> used_;
  std::vector<std::size_t> fresh_;  ///< points of a pair without a match
  std::vector<std::uint8_t> anew_;  ///< per pair
};

}  // namespace brim
