#pragma once

#include <algorithm>
#include <cmath>

namespace brim {

/// Density of a solid near its surface: cubic smoothstep from 1 inside to 0 outside, 1/2 on the surface.
///   ramp(d, w) = 1 for d <= −w/2, 0 for d >= w/2, 1 − (3 t² − 2 t³) with t = d/w + 1/2 between
/// @param d  [m]  signed distance to the surface, negative inside
/// @param w  [m]  ramp width, 2h to 3h (3h makes contact isotropic to 0.2 %)
inline double ramp(double d, double w) {
  const double t = std::clamp(d / w + 0.5, 0.0, 1.0);
  return 1.0 - t * t * (3.0 - 2.0 * t);
}

/// Derivative of the ramp by d, [1/m]; at most 0.
inline double ramp_slope(double d, double w) {
  const double t = std::clamp(d / w + 0.5, 0.0, 1.0);
  return -6.0 * t * (1.0 - t) / w;
}

/// Signed distance of a given density, [m]: the inverse of ramp, within ±w/2.
///   t solves 3 t² − 2 t³ = y:  t = 1/2 − sin(asin(1 − 2 y) / 3)
inline double ramp_inverse(double rho, double w) {
  const double y = std::clamp(1.0 - rho, 0.0, 1.0);
  return -w * std::sin(std::asin(1.0 - 2.0 * y) / 3.0);
}

}  // namespace brim
