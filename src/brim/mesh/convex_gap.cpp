#include "brim/mesh/convex_gap.h"

#include <limits>

#include "brim/mesh/distance.h"

namespace brim {

namespace {

constexpr std::array<std::array<std::size_t, 4>, 4> kFacesAndApex = {
    {{0, 1, 2, 3}, {0, 1, 3, 2}, {0, 2, 3, 1}, {1, 2, 3, 0}}};

/// True unless the origin and the apex are on the same side of a face.
bool beyond_face(const std::array<Vec3, 4>& x, const std::array<std::size_t, 4>& f) {
  const Vec3 normal = (x[f[1]] - x[f[0]]).cross(x[f[2]] - x[f[0]]);
  return !(-normal.dot(x[f[0]]) * normal.dot(x[f[3]] - x[f[0]]) > 0.0);
}

}  // namespace

void GapSimplex::add(const Vec3& corner) {
  corner_[static_cast<std::size_t>(count_++)] = corner;
  std::array<Vec3, 4> kept = corner_;
  std::array<double, 4> weight{};
  if (count_ == 2) {
    const Vec3 along = corner_[1] - corner_[0];
    const double length2 = along.squaredNorm();
    const double s = length2 > 0.0 ? std::clamp(-corner_[0].dot(along) / length2, 0.0, 1.0) : 0.0;
    weight = {1.0 - s, s, 0.0, 0.0};
    nearest_ = corner_[0] + s * along;
  } else {
    double best2 = std::numeric_limits<double>::infinity();
    for (const auto& f : kFacesAndApex) {
      if (count_ == 3 && f[3] != 3) continue;
      if (count_ == 4 && !beyond_face(corner_, f)) continue;
      const TrianglePoint t = closest_on_triangle(Vec3::Zero(), corner_[f[0]], corner_[f[1]], corner_[f[2]]);
      if (!(t.point.squaredNorm() < best2)) continue;
      best2 = t.point.squaredNorm();
      nearest_ = t.point;
      kept = {corner_[f[0]], corner_[f[1]], corner_[f[2]], Vec3::Zero()};
      weight = {t.barycentric[0], t.barycentric[1], t.barycentric[2], 0.0};
    }
    if (!std::isfinite(best2)) {  // in front of no face: inside
      nearest_ = Vec3::Zero();
      return;
    }
  }
  count_ = 0;
  for (std::size_t i = 0; i < 3; ++i)
    if (weight[i] > 0.0) corner_[static_cast<std::size_t>(count_++)] = kept[i];
}

}  // namespace brim
