#include "brim/contact/patch_center.h"

#include <cmath>

namespace brim {

namespace {

/// [voxels] higher differences of the gap up to which it counts as a parabola.
constexpr double kParabola = 0.06;
/// [1/voxels] curvature that is flat: half of a shift is made there.
constexpr double kFlat = 0.005;
/// [voxels] half the width of a patch that is one place of touch; farthest that it is moved.
constexpr double kNarrow = 3.0, kFarthest = 0.75;

struct Parabola {
  double slope = 0.0, curvature = 0.0;  ///< [-], [1/m]
  bool fits = false;
};

/// The gap along a line through x.
Parabola along(const CubeSide& a, const CubeSide& b, const Vec3& x, const Vec3& e, double h) {
  const auto gap = [&](double t) { return gap_between(a, b, x + t * h * e); };
  const double m2 = gap(-1.0), m1 = gap(-0.5), p0 = gap(0.0), p1 = gap(0.5), p2 = gap(1.0);
  const double third = p2 - 2.0 * p1 + 2.0 * m1 - m2, fourth = p2 - 4.0 * p1 + 6.0 * p0 - 4.0 * m1 + m2;
  return {(p2 - m2) / (2.0 * h), (p2 - 2.0 * p0 + m2) / (h * h),
          std::abs(third) < kParabola * h && std::abs(fourth) < kParabola * h};
}

}  // namespace

void center_on_least_gap(const CubeSide& a, const CubeSide& b, double h, std::span<Contact> contacts) {
  double weight = 0.0;
  Vec3 x = Vec3::Zero(), n = Vec3::Zero();
  for (const Contact& c : contacts) {
    const double w = std::max(0.0, double{c.overlap});
    weight += w, x += w * c.point, n += w * (c.gradient_a - c.gradient_b).cast<double>();
  }
  if (!(weight > 0.0) || !(n.norm() > 0.0)) return;
  x /= weight, n.normalize();
  int across = 0;
  n.cwiseAbs().minCoeff(&across);
  Vec3 e = Vec3::Unit(across);
  e = (e - n * n.dot(e)).normalized();
  const Vec3 f = n.cross(e), diagonal = (e + f).normalized();
  // The directions in which the gap bends most and least.
  const double bend_e = along(a, b, x, e, h).curvature, bend_f = along(a, b, x, f, h).curvature;
  const double mixed = along(a, b, x, diagonal, h).curvature - 0.5 * (bend_e + bend_f);
  const double turn = 0.5 * std::atan2(2.0 * mixed, bend_e - bend_f);
  const Vec3 major = std::cos(turn) * e + std::sin(turn) * f;
  for (const Vec3& v : {major, Vec3(n.cross(major))}) {
    const Parabola p = along(a, b, x, v, h);
    if (!p.fits || !(p.curvature > 0.0) || std::abs(p.slope) > kFarthest * h * p.curvature) continue;
    bool narrow = true;
    for (const Contact& c : contacts)
      narrow = narrow && (!(c.overlap > 0.0f) || std::abs(v.dot(c.point - x)) < kNarrow * h);
    if (!narrow) continue;
    const double bent = p.curvature / (p.curvature + kFlat / h), least = v.dot(x) - p.slope / p.curvature;
    for (Contact& c : contacts) c.point += bent * (least - v.dot(c.point)) * v;
  }
}

}  // namespace brim
