#include "brim/map/shell_weights.h"

#include <algorithm>
#include <limits>

namespace brim {

namespace {

/// Barycentric weights of the point of a triangle that is closest to the point with plane weights b outside of it:
/// the best of the three edges.
Vec3 clamped_to_edges(const Vec3& r, const std::array<Vec3, 3>& x) {
  Vec3 best = Vec3::Zero();
  double best_distance = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const Vec3 e = x[j] - x[i];
    const double length2 = e.squaredNorm();
    const double t = length2 > 0.0 ? std::clamp((r - x[i]).dot(e) / length2, 0.0, 1.0) : 0.0;
    const double distance = (x[i] + t * e - r).squaredNorm();
    if (distance < best_distance) {
      best_distance = distance;
      best.setZero();
      best[i] = 1.0 - t;
      best[j] = t;
    }
  }
  return best;
}

/// Plane weights b of a point, their gradients and the normal n of the triangle; b is infinite where it has no area.
struct PlaneWeights {
  Vec3 b = Vec3::Constant(std::numeric_limits<double>::infinity()), n = Vec3::UnitZ();
  std::array<Vec3, 3> gradient;
};

PlaneWeights plane_weights(const Vec3& r, const std::array<Vec3, 3>& c) {
  PlaneWeights w;
  const Vec3 m = (c[1] - c[0]).cross(c[2] - c[0]);
  const double m2 = m.squaredNorm();
  if (!(m2 > 0.0)) return w;
  w.n = m / std::sqrt(m2);
  // ∇b_i = n × (edge opposite to i) / (2 area).
  for (int i = 0; i < 3; ++i) {
    w.gradient[i] = m.cross(c[(i + 2) % 3] - c[(i + 1) % 3]) / m2;
    w.b[i] = w.gradient[i].dot(r - c[(i + 1) % 3]);
  }
  w.b[0] = 1.0 - w.b[1] - w.b[2];
  return w;
}

std::array<Vec3, 3> corners(const std::array<std::int32_t, 3>& triangle, std::span<const Vec3> x) {
  return {x[triangle[0]], x[triangle[1]], x[triangle[2]]};
}

}  // namespace

double ShellWeightsMap::weight_sum(const Vec3& r, const std::array<std::int32_t, 3>& triangle,
                                   std::span<const Vec3> x) {
  return plane_weights(r, corners(triangle, x)).b.cwiseAbs().sum();
}

void ShellWeightsMap::set(std::size_t p, const Vec3& r, const std::array<std::int32_t, 3>& triangle,
                          std::span<const Vec3> x) {
  const std::array<Vec3, 3> c = corners(triangle, x);
  auto [b, n, gradient] = plane_weights(r, c);
  double d = n.dot(r - c[0]);
  if (!(b.cwiseAbs().sum() <= kMaxWeight)) {
    b = clamped_to_edges(r, c);
    d = 0.0;
    gradient.fill(Vec3::Zero());
  }
  direction_[p] = n;
  for (int i = 0; i < 3; ++i) {
    particle_[3 * p + i] = triangle[i];
    weight_[3 * p + i] = b[i];
    lever_[3 * p + i] = -d * gradient[i];
  }
}

}  // namespace brim
