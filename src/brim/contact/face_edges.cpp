#include "brim/contact/face_edges.h"

#include <cmath>

namespace brim {

namespace {

/// [voxels] change of the gap along a face that counts as none.
constexpr double kLevel = 0.02;
/// Least slope of the gap beyond an edge.
constexpr double kSteep = 0.5;
/// Halvings of the way to an edge: 2^-6 of a voxel.
constexpr int kHalvings = 6;

/// Way from x along e to an edge, [m]; 0 where there is none within h, or the other way is no face. @param level  the
/// gap at x
double way_to_edge(const CubeSide& a, const CubeSide& b, const Vec3& x, const Vec3& e, double h, double level) {
  const double most = level + kLevel * h, far = gap_between(a, b, x + h * e);
  if (far <= most || std::abs(gap_between(a, b, x - 0.5 * h * e) - level) > kLevel * h) return 0.0;
  double lo = 0.0, hi = h;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (lo + hi);
    (gap_between(a, b, x + middle * e) <= most ? lo : hi) = middle;
  }
  if (far - level < kSteep * (h - lo)) return 0.0;
  // A ridge between here and there is no face.
  if (gap_between(a, b, x + 0.5 * lo * e) < level - kLevel * h) return 0.0;
  return std::max(0.0, lo - kLevel * h);
}

}  // namespace

Vec3 carried_to_edge(const CubeSide& a, const CubeSide& b, const Vec3& x, const Vec3& n, double h) {
  int across = 0;
  n.cwiseAbs().minCoeff(&across);
  Vec3 e = Vec3::Unit(across);
  e = (e - n * n.dot(e)).normalized();
  Vec3 y = x;
  const double level = gap_between(a, b, x);
  for (const Vec3& direction : {e, Vec3(n.cross(e))}) {
    const double ahead = way_to_edge(a, b, y, direction, h, level), behind = way_to_edge(a, b, y, -direction, h, level);
    // Between two edges the middle stands for both.
    y += (ahead > 0.0 && behind > 0.0 ? 0.5 : 1.0) * (ahead - behind) * direction;
  }
  return y;
}

void carry_to_edges(const CubeSide& a, const CubeSide& b, double h, std::span<Contact> contacts) {
  for (Contact& c : contacts) {
    const Vec3 n = (c.gradient_a - c.gradient_b).cast<double>();
    const double length = n.norm();
    if (length > 0.0) c.point = carried_to_edge(a, b, c.point, n / length, h);
  }
}

}  // namespace brim
