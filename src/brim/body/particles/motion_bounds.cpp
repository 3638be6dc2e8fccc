#include "brim/body/particles/motion_bounds.h"

#include <limits>

#include "brim/core/simd.h"

namespace brim {

namespace {

/// Least and largest of vectors, four numbers at a time of which the last means nothing.
struct Range {
  Lanes lo, hi;
  BRIM_INLINE void extend(const Lanes& x) {
    lo = x < lo ? x : lo;
    hi = x > hi ? x : hi;
  }
  BRIM_INLINE Aabb box() const { return {Vec3(lo[0], lo[1], lo[2]), Vec3(hi[0], hi[1], hi[2])}; }
};

BRIM_WIDE MotionCluster bounds(std::span<const Vec3> x, std::span<const double> v, std::size_t stride,
                               std::span<const std::int32_t> nodes, double reach) {
  const auto last = static_cast<std::int32_t>(x.size()) - 1;
  // Nothing may follow the last vector in memory.
  const double last_x[4] = {x[last].x(), x[last].y(), x[last].z(), 0.0};
  const double* const last_of_v = v.data() + stride * static_cast<std::size_t>(last);
  const double last_v[4] = {last_of_v[0], last_of_v[1], last_of_v[2], 0.0};
  constexpr double kMost = std::numeric_limits<double>::infinity();
  Range place{Lanes{} + kMost, Lanes{} - kMost}, speed = place;
  for (const std::int32_t i : nodes) {
    place.extend(load_lanes(i < last ? x[i].data() : last_x));
    speed.extend(load_lanes(i < last ? v.data() + stride * static_cast<std::size_t>(i) : last_v));
  }
  return {place.box().inflated(reach), speed.box()};
}

}  // namespace

MotionCluster motion_bounds(std::span<const Vec3> x, std::span<const double> v, std::span<const std::int32_t> nodes,
                            double reach) {
  return bounds(x, v, v.size() / x.size(), nodes, reach);
}

}  // namespace brim
