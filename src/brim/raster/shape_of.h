#pragma once

#include <cmath>

#include "brim/core/error.h"
#include "brim/raster/averaged_shape.h"
#include "brim/raster/convex_distance.h"
#include "brim/raster/known_distance.h"
#include "brim/raster/shape_fill.h"

namespace brim {

/// Gives a shape its block filler and its interfaces from its own distance, without a virtual call per node.
/// @tparam Self  the shape, with double operator()(const Vec3& p): its exact signed distance, [m]
template <class Self>
class ShapeOf : public Shape, public KnownDistance {
 public:
  double distance(const Vec3& p) const final { return self()(p); }
  double slack() const final { return 0.0; }
  double rough_distance(const Vec3& p) const final { return self()(p); }
  void distances(const PlaceArrays& at, double* d) const override {
    for (int i = 0; i < at.count; ++i) d[i] = self()(Vec3(at.x[i], at.y[i], at.z[i]));
  }
  bool by_rows() const final { return true; }
  void fill(const Pose& pose, const TileKey& tile, double h, double w, DensityBlock& out) const final {
    fill_block(self(), pose, tile, h, w, out);
  }

 private:
  const Self& self() const { return static_cast<const Self&>(*this); }
};

/// The same for a convex shape, whose distance has a gradient.
template <class Self>
class ConvexShapeOf : public ShapeOf<Self>, public ConvexDistance {
 public:
  const ConvexDistance* convex() const final { return this; }
};

/// The same for a shape with a formula for the share of its matter in a ball: double share(p, w). @tparam Base  one of
/// the two above
template <class Self, class Base>
class RoundedShapeOf : public Base, public AveragedDistances {
 public:
  const KnownDistance& averaged(double w) const final { return widths_.of(static_cast<const Self&>(*this), w); }
  bool detailed() const final { return false; }

 private:
  AveragedWidths<Self> widths_;
};

/// @throws InputError  unless a length is positive and finite
inline void check_length(const char* what, double value) {
  if (!(value > 0.0) || !std::isfinite(value))
    throw InputError(fmt::format("{} is {}, but must be a positive finite length [m]", what, value));
}

}  // namespace brim
