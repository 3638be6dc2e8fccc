#pragma once

#include <cmath>
#include <numbers>
#include <utility>

#include "brim/core/simd.h"

namespace brim {

/// Cubic spline kernel of finite support (Monaghan 1992), normalised in space: ∫ W dV = 1.
///   W(r) = 8/(π H³) · { 1 − 6 q² + 6 q³ for q <= 1/2;  2 (1 − q)³ for q <= 1 },   q = r/H
/// With a support of two spacings it has about 33 neighbours and causes no pairing of particles.
class FluidKernel {
 public:
  /// @param support  [m] H, > 0
  explicit FluidKernel(double support)
      : support_(support), inverse_(1.0 / support), scale_(8.0 / (std::numbers::pi * support * support * support)) {}

  double support() const { return support_; }
  /// [1/m³]; r >= 0
  double value(double r) const {
    const double q = r * inverse_;
    if (q >= 1.0) return 0.0;
    if (q > 0.5) return scale_ * 2.0 * (1.0 - q) * (1.0 - q) * (1.0 - q);
    return scale_ * (1.0 - 6.0 * q * q * (1.0 - q));
  }
  /// W'(r) / r, [1/m⁵], finite at 0: ∇W = slope_over_r · x.
  double slope_over_r(double r) const {
    const double q = r * inverse_;
    if (q >= 1.0) return 0.0;
    const double f = scale_ * inverse_ * inverse_;
    if (q > 0.5) return -6.0 * f * (1.0 - q) * (1.0 - q) / q;
    return f * (18.0 * q - 12.0);
  }
  /// Both for four distances. @param r  0 <= r < H
  BRIM_INLINE std::pair<Lanes, Lanes> value_and_slope(const Lanes& r) const {
    const Lanes q = r * inverse_, u = 1.0 - q;
    const double f = scale_ * inverse_ * inverse_;
    const LaneFlags outer = q > 0.5;
    return {outer ? scale_ * 2.0 * u * u * u : scale_ * (1.0 - 6.0 * q * q * u),
            outer ? -6.0 * f * u * u / q : f * (18.0 * q - 12.0)};
  }

  /// ∫ W over the half space that begins at distance d from the centre, [-]: 1/2 at 0, 0 for d >= H.
  double beyond(double d) const {
    const double t = std::abs(d) * inverse_;
    if (t >= 1.0) return d > 0.0 ? 0.0 : 1.0;
    // The plane marginal is 2π ∫_t^1 W q dq; integrated once more. Both pieces are polynomials.
    const auto outer = [](double q) {  // ∫∫ of 2 (1 − q)³ q
      const double u = 1.0 - q;
      return u * u * u * u * u * (1.0 / 10.0 - u / 15.0);
    };
    double value = outer(t);
    if (t < 0.5) {
      // 1 − 6 q² + 6 q³ − 2 (1 − q)³ = −(1 − 2q)³, the extra cubic of the inner piece.
      const double u = 1.0 - 2.0 * t;
      value -= u * u * u * u * u * (1.0 / 160.0 - u / 240.0);
    }
    value *= 16.0;
    return d > 0.0 ? value : 1.0 - value;
  }

 private:
  double support_, inverse_, scale_;
};

}  // namespace brim
