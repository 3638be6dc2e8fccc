#include "brim/mesh/ray.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "brim/mesh/distance.h"

namespace brim {

namespace {

/// Keeps the nearer of two entries.
void keep_nearer(const std::optional<RayEntry>& other, std::optional<RayEntry>& best) {
  if (other && (!best || other->distance < best->distance)) best = other;
}

std::optional<RayEntry> enter_ball(const Ray& ray, const Vec3& center, double radius) {
  const Vec3 m = ray.origin - center;
  const double nearest = -m.dot(ray.direction);
  const double half2 = radius * radius - (m + nearest * ray.direction).squaredNorm();
  if (!(half2 >= 0.0)) return {};
  const double t = nearest - std::sqrt(half2);
  if (t < 0.0 || t > ray.length) return {};
  return RayEntry{t, (m + t * ray.direction).normalized()};
}

/// The round side of a cylinder between two points, without its ends.
std::optional<RayEntry> enter_side(const Ray& ray, const Vec3& a, const Vec3& b, double radius) {
  const double length = (b - a).norm();
  if (!(length > 0.0)) return {};
  const Vec3 axis = (b - a) / length, m = ray.origin - a;
  const Vec3 across = ray.direction - ray.direction.dot(axis) * axis, from_axis = m - m.dot(axis) * axis;
  const double speed2 = across.squaredNorm();
  if (!(speed2 > 1e-30)) return {};
  const double nearest = -from_axis.dot(across) / speed2;
  const double half2 = (radius * radius - (from_axis + nearest * across).squaredNorm()) / speed2;
  if (!(half2 >= 0.0)) return {};
  const double t = nearest - std::sqrt(half2), along = (m + t * ray.direction).dot(axis);
  if (t < 0.0 || t > ray.length || along < 0.0 || along > length) return {};
  return RayEntry{t, (from_axis + t * across).normalized()};
}

std::optional<RayEntry> enter_triangle(const Ray& ray, const Vec3& a, const Vec3& b, const Vec3& c) {
  // Coordinates in which the ray is the z axis.
  int kz = 0;
  ray.direction.cwiseAbs().maxCoeff(&kz);
  int kx = (kz + 1) % 3, ky = (kz + 2) % 3;
  if (ray.direction[kz] < 0.0) std::swap(kx, ky);
  const double sx = ray.direction[kx] / ray.direction[kz], sy = ray.direction[ky] / ray.direction[kz];
  const Vec3 A = a - ray.origin, B = b - ray.origin, C = c - ray.origin;
  const double ax = A[kx] - sx * A[kz], ay = A[ky] - sy * A[kz];
  const double bx = B[kx] - sx * B[kz], by = B[ky] - sy * B[kz];
  const double cx = C[kx] - sx * C[kz], cy = C[ky] - sy * C[kz];
  const double u = cx * by - cy * bx, v = ax * cy - ay * cx, w = bx * ay - by * ax;
  if ((u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0)) return {};
  const double sum = u + v + w;
  if (sum == 0.0) return {};
  const double t = (u * A[kz] + v * B[kz] + w * C[kz]) / (sum * ray.direction[kz]);
  if (!(t >= 0.0) || t > ray.length) return {};
  const Vec3 normal = (b - a).cross(c - a).normalized();
  return RayEntry{t, normal.dot(ray.direction) > 0.0 ? Vec3(-normal) : normal};
}

/// The nearest point of the simplex without its radius.
Vec3 nearest_in(const Vec3& p, const RoundedSimplex& s) {
  if (s.corners == 1) return s.corner[0];
  if (s.corners == 3) return closest_on_triangle(p, s.corner[0], s.corner[1], s.corner[2]).point;
  const Vec3 along = s.corner[1] - s.corner[0];
  const double length2 = along.squaredNorm();
  return length2 > 0.0 ? Vec3(s.corner[0] + std::clamp((p - s.corner[0]).dot(along) / length2, 0.0, 1.0) * along)
                       : s.corner[0];
}

}  // namespace

bool clip(const Ray& ray, const Aabb& box, double& begin, double& end) {
  begin = 0.0, end = ray.length;
  for (int i = 0; i < 3; ++i) {
    if (ray.direction[i] == 0.0) {
      if (ray.origin[i] < box.lo[i] || ray.origin[i] > box.hi[i]) return false;
      continue;
    }
    const double p = (box.lo[i] - ray.origin[i]) / ray.direction[i];
    const double q = (box.hi[i] - ray.origin[i]) / ray.direction[i];
    begin = std::max(begin, std::min(p, q)), end = std::min(end, std::max(p, q));
  }
  return begin <= end;
}

Aabb RoundedSimplex::bounds() const {
  Aabb box;
  for (int i = 0; i < corners; ++i) box.extend(corner[static_cast<std::size_t>(i)]);
  return box.inflated(radius);
}

Vec3 RoundedSimplex::support(const Vec3& direction) const {
  std::size_t best = 0;
  for (std::size_t i = 1; i < static_cast<std::size_t>(corners); ++i)
    if (corner[i].dot(direction) > corner[best].dot(direction)) best = i;
  return corner[best];
}

std::optional<RayEntry> enter(const Ray& ray, const RoundedSimplex& s) {
  const auto& [a, b, c] = s.corner;
  const double r = s.radius;
  if (s.corners == 3 && r == 0.0) return enter_triangle(ray, a, b, c);
  std::optional<RayEntry> best;
  if (!(r > 0.0)) return best;
  // The matter is the union of its faces, sides and balls, and the origin is outside: the first entry is that of one.
  const auto n = static_cast<std::size_t>(s.corners);
  for (std::size_t i = 0; i < n; ++i) {
    keep_nearer(enter_ball(ray, s.corner[i], r), best);
    if (n > 1 && (n == 3 || i == 0)) keep_nearer(enter_side(ray, s.corner[i], s.corner[(i + 1) % n], r), best);
  }
  if (n == 3) {
    const Vec3 lift = r * (b - a).cross(c - a).normalized();
    keep_nearer(enter_triangle(ray, a + lift, b + lift, c + lift), best);
    keep_nearer(enter_triangle(ray, a - lift, b - lift, c - lift), best);
  }
  return best;
}

NearPoint nearest(const Vec3& p, const RoundedSimplex& s) {
  const Vec3 middle = nearest_in(p, s), away = p - middle;
  const double length = away.norm();
  NearPoint out;
  out.distance = length - s.radius;
  if (length > 1e-12 * (1.0 + p.norm()))
    out.normal = away / length;
  else if (s.corners == 3)
    out.normal = (s.corner[1] - s.corner[0]).cross(s.corner[2] - s.corner[0]).normalized();
  else if (s.corners == 2)
    out.normal = (s.corner[1] - s.corner[0]).unitOrthogonal();
  out.point = middle + s.radius * out.normal;
  return out;
}

}  // namespace brim
