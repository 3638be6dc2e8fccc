#pragma once

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "brim/math/types.h"

namespace brim {

/// Extent of a list of points in any direction, eight points at a time.
///   least = min_i a·x_i,  largest = max_i a·x_i,   in single precision: to 2e-7 of the farthest point
/// Tests: tests/world/vertex_range_test.cpp
class VertexRange {
 public:
  explicit VertexRange(std::span<const Vec3> points);
  bool empty() const { return count_ == 0; }
  /// [m] mean of the points.
  const Vec3& mean() const { return mean_; }
  /// Minimum and maximum of a·x. @param a  direction
  std::pair<double, double> along(const Vec3& a) const;

 private:
  std::size_t count_ = 0;
  Vec3 mean_ = Vec3::Zero();
  std::vector<float> x_, y_, z_;  ///< relative to the mean; padded with the last point to a multiple of eight
};

/// Creates one VertexRange shared by all bodies with the same points.
class VertexRanges {
 public:
  std::shared_ptr<const VertexRange> of(const std::vector<Vec3>& points);

 private:
  std::vector<std::pair<const std::vector<Vec3>*, std::shared_ptr<const VertexRange>>> known_;
};

}  // namespace brim
