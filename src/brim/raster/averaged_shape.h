#pragma once

#include <map>
#include <memory>
#include <mutex>

#include "brim/math/ramp.h"
#include "brim/raster/averaged_distances.h"
#include "brim/raster/known_distance.h"

namespace brim {

/// A shape averaged over balls of diameter w. @tparam Shape  has double operator()(p), its distance, and double
/// share(p, w), the volume fraction of the ball about p
template <class Shape>
class AveragedShape final : public KnownDistance {
 public:
  /// @param shape  must outlive this  @param w  [m]
  AveragedShape(const Shape& shape, double w) : shape_(shape), w_(w) {}
  double slack() const override { return w_; }
  double rough_distance(const Vec3& p) const override {
    const double d = shape_(p), half = 0.5 * w_;
    // At an edge the ball may touch matter at distances of up to half a ramp along each of the two faces.
    if (std::abs(d) > 2.0 * half) return d;
    const double share = shape_.share(p, w_);
    if (share > 0.0 && share < 1.0) return ramp_inverse(share, w_);
    return share > 0.0 ? std::min(d, -half) : std::max(d, half);
  }
  /// A ball of radius d about p holds no matter, so that the ball of diameter w is full to at most 1 − (2d/w)³: its
  /// distance under the ramp is at least d − 0.56 w (d − w/2 beside a flat or convex surface).
  double least_distance(const Vec3& p) const override { return shape_(p) - kMostAdded * w_; }
  bool by_rows() const override { return false; }

 private:
  static constexpr double kMostAdded = 0.56;
  const Shape& shape_;
  double w_;
};

/// Builds the averaged solids of a shape on the first request for each width.
template <class Shape>
class AveragedWidths {
 public:
  const KnownDistance& of(const Shape& shape, double w) const {
    const std::scoped_lock lock(mutex_);
    auto& solid = width_[w];
    if (!solid) solid = std::make_unique<AveragedShape<Shape>>(shape, w);
    return *solid;
  }

 private:
  mutable std::mutex mutex_;
  mutable std::map<double, std::unique_ptr<AveragedShape<Shape>>> width_;
};

}  // namespace brim
