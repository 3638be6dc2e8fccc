#include "brim/map/line_weights.h"

#include <algorithm>
#include <cmath>

namespace brim {

void LineWeightsMap::set(std::size_t p, const Vec3& r, const std::array<std::int32_t, 2>& segment,
                         std::span<const Vec3> x) {
  const Vec3 a = x[segment[0]], ab = x[segment[1]] - a;
  const double length2 = ab.squaredNorm();
  double s = length2 > 0.0 ? (r - a).dot(ab) / length2 : 0.0;
  Vec3 offset = r - a - s * ab;
  Vec3 lever = length2 > 0.0 ? Vec3(ab / length2) : Vec3::Zero();  // t / L
  const bool far =
      !(std::abs(s) + std::abs(1.0 - s) <= kMaxWeight) || !(offset.squaredNorm() <= kMaxWeight * kMaxWeight * length2);
  if (far) {
    s = std::clamp(s, 0.0, 1.0);
    offset.setZero();
    lever.setZero();
  }
  direction_[p] = offset;
  const double weight[2] = {1.0 - s, s};
  for (int i = 0; i < 2; ++i) {
    particle_[2 * p + i] = segment[i];
    weight_[2 * p + i] = weight[i];
    lever_[2 * p + i] = i == 0 ? lever : Vec3(-lever);
  }
}

}  // namespace brim
