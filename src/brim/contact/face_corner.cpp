#include "brim/contact/face_corner.h"

#include <array>
#include <cmath>

namespace brim {

namespace {

/// [voxels] step along a ray, and the number of steps; rise at which the edge lies behind, beyond the bend of sampled
/// distances; distance over which the slope is taken there; deepest dip on the way, else it meets a wall.
constexpr double kRayStep = 0.5, kRiseBeyond = 0.35, kOn = 0.3, kDeepestDip = 0.1;
constexpr int kRaySteps = 10, kFiner = 5;
/// Smallest slope beyond an edge; smallest share of it along the edge's own normal.
constexpr double kSteepBeyond = 0.4;
/// [voxels] from the hit to where the normal of an edge is read, and half of the difference for it.
constexpr double kReadAt = 0.6, kHalfDifference = 0.2;
/// [rad] of the two rays beside a direction.
constexpr double kAside = 0.7;
/// Cosines between the normals of two edges: up to the first they may meet in a corner, from the second on they are
/// one.
constexpr double kCorner = 0.85, kOneEdge = 0.98;
/// [voxels] from an edge to the ray along it; from a corner inwards, to where the face must be; largest rise there.
constexpr double kFromEdge = 0.7, kFromCorner = 0.3, kRiseAtCorner = 0.1;

}  // namespace

void FaceCorner::rises(const Vec3& from, const Vec3& way, const double* t, int count, double* rise) const {
  constexpr int kMost = 16;
  std::array<double, kMost> x, y, z, d;
  const auto add = [&](const CubeSide& side, bool first) {
    const Vec3 p = side.pose.to_local(from), e = side.pose.rotation.transpose() * way;
    for (int i = 0; i < count; ++i)
      x[i] = p.x() + t[i] * e.x(), y[i] = p.y() + t[i] * e.y(), z[i] = p.z() + t[i] * e.z();
    side.solid->distances({x.data(), y.data(), z.data(), count}, d.data());
    for (int i = 0; i < count; ++i) rise[i] = first ? d[i] : rise[i] + d[i];
  };
  add(a_, true), add(b_, false);
  for (int i = 0; i < count; ++i) rise[i] -= face_.gap_at(from + t[i] * way);
}

double FaceCorner::rise(const Vec3& x) const {
  const double t = 0.0;
  double r;
  rises(x, Vec3::Zero(), &t, 1, &r);
  return r;
}

std::optional<FaceCorner::Edge> FaceCorner::edge_along(const Vec3& from, const Vec3& way) const {
  const double beyond = kRiseBeyond * h_;
  std::array<double, kRaySteps + 1> t, r;
  for (int i = 0; i <= kRaySteps; ++i) t[i] = i * kRayStep * h_;
  rises(from, way, t.data(), kRaySteps + 1, r.data());
  int k = 0;
  for (; k <= kRaySteps && r[k] < beyond; ++k)
    if (r[k] < -kDeepestDip * h_) return std::nullopt;
  if (k == 0 || k > kRaySteps) return std::nullopt;
  // Where r = beyond, between two of finer steps, and its slope from there on.
  const double begin = t[k - 1];
  std::array<double, kFiner + 3> s, q;
  const int fine = kFiner + 3;
  for (int i = 0; i < fine; ++i) s[i] = begin + i * kRayStep * h_ / kFiner;
  rises(from, way, s.data(), fine, q.data());
  int j = 1;
  while (j + 1 < fine && q[j] < beyond) ++j;
  if (!(q[j] >= beyond && q[j] > q[j - 1])) return std::nullopt;
  const double at = s[j - 1] + (s[j] - s[j - 1]) * (beyond - q[j - 1]) / (q[j] - q[j - 1]);
  const double on[] = {at + 0.5 * kOn * h_, at + 1.5 * kOn * h_};
  double far[2];
  rises(from, way, on, 2, far);
  const double slope = (far[1] - far[0]) / (kOn * h_);
  if (!(slope >= kSteepBeyond)) return std::nullopt;
  Edge edge;
  edge.x = from + (on[0] - far[0] / slope) * way;
  const Vec3 read = edge.x + kReadAt * h_ * way, e = way, f = face_.n.cross(way);
  const double both[] = {-kHalfDifference * h_, kHalfDifference * h_};
  double along_e[2], along_f[2];
  rises(read, e, both, 2, along_e), rises(read, f, both, 2, along_f);
  const Vec3 gradient = (along_e[1] - along_e[0]) * e + (along_f[1] - along_f[0]) * f;
  const double size = gradient.norm();
  if (!(size > kSteepBeyond * 2.0 * kHalfDifference * h_)) return std::nullopt;
  edge.normal = gradient / size;
  return edge;
}

std::optional<Vec3> FaceCorner::meeting(const Edge& one, const Edge& other) const {
  const double c = one.normal.dot(other.normal);
  if (c > kCorner || c < -kOneEdge) return std::nullopt;
  // x = one.x + u along the first edge.
  const Vec3 along = face_.n.cross(one.normal);
  const double rate = other.normal.dot(along);
  const Vec3 x = one.x + other.normal.dot(other.x - one.x) / rate * along;
  const Vec3 out = (one.normal + other.normal).normalized();
  if (rise(x - kFromCorner * h_ * out) > kRiseAtCorner * h_ || rise(x + kFromCorner * h_ * out) < kRiseAtCorner * h_)
    return std::nullopt;
  return x;
}

std::optional<Vec3> FaceCorner::find(const Vec3& from, const Vec3& out) const {
  Vec3 way = out - face_.n * face_.n.dot(out);
  if (!(way.norm() > 0.0)) return std::nullopt;
  way.normalize();
  const Vec3 aside = face_.n.cross(way);
  const auto turned = [&](double angle) { return Vec3(std::cos(angle) * way + std::sin(angle) * aside); };
  const auto left = edge_along(from, turned(kAside)), right = edge_along(from, turned(-kAside));
  if (left && right)
    if (const auto corner = meeting(*left, *right)) return corner;
  auto ahead = edge_along(from, way);
  if (!ahead) ahead = left ? left : right;
  if (!ahead) return std::nullopt;
  // Along the edge ahead, to where the next one begins.
  Vec3 along = face_.n.cross(ahead->normal);
  if (along.dot(way) < 0.0) along = -along;
  if (const auto next = edge_along(ahead->x - kFromEdge * h_ * ahead->normal, along))
    if (const auto corner = meeting(*ahead, *next)) return corner;
  return ahead->x;
}

}  // namespace brim
