#include "brim/response/friction_radius.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

namespace brim {

namespace {

/// Bulge of a rim beyond the chord between two corners, relative, above which it counts as round.
constexpr double kBulge = 1e-3;

using Vec2 = Eigen::Vector2d;

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Area, and integral of the distance from the origin, over a sector.
struct Sector {
  double area = 0.0, moment = 0.0;
};

/// The triangle between the origin and a chord: ∫ r dA = p³/3 ∫ sec³, p the chord's distance.
Sector triangle(const Vec2& a, const Vec2& b) {
  const Vec2 d = b - a;
  const double length = d.norm(), twice = cross(a, b);
  if (!(length > 0.0) || !(twice > 0.0)) return {};
  const double p = twice / length;
  const auto part = [&](double along) {
    const double t = along / p;
    return 0.5 * (t * std::sqrt(1.0 + t * t) + std::asinh(t));
  };
  return {0.5 * twice, p * p * p / 3.0 * (part(d.dot(b) / length) - part(d.dot(a) / length))};
}

/// Simpson's rule over the angle of a sector whose rim is at ra, rm, rb.
Sector round_sector(double angle, double ra, double rm, double rb) {
  return {angle / 12.0 * (ra * ra + 4.0 * rm * rm + rb * rb),
          angle / 18.0 * (ra * ra * ra + 4.0 * rm * rm * rm + rb * rb * rb)};
}

}  // namespace

void place_grips(std::span<RowPoint> corners, const Vec3& normal,
                 const std::function<double(const Vec3& center, const Vec3& way)>& rim) {
  const std::size_t n = corners.size();
  if (n < 2) return;
  const auto across = tangents_of(normal);
  Vec3 middle = Vec3::Zero();
  for (const RowPoint& r : corners) middle += r.point / static_cast<double>(n);
  std::vector<Vec2> at(n);
  for (std::size_t i = 0; i < n; ++i) at[i] = across.transpose() * (corners[i].point - middle);
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
    return std::atan2(at[i].y(), at[i].x()) < std::atan2(at[j].y(), at[j].x());
  });
  Vec2 center = Vec2::Zero();
  double twice = 0.0, longest = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 &a = at[order[i]], &b = at[order[(i + 1) % n]];
    twice += cross(a, b), center += cross(a, b) * (a + b) / 3.0;
    longest = std::max(longest, a.squaredNorm());
  }
  double share = 0.5;  // of a segment
  if (n > 2 && twice > 1e-3 * longest) {
    center /= twice;
    for (Vec2& x : at) x -= center;
    Sector sum;
    double mean = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      const Vec2 &a = at[order[i]], &b = at[order[(i + 1) % n]];
      mean += a.norm() / static_cast<double>(n);
      Sector s = triangle(a, b);
      const Vec2 way = (a.normalized() + b.normalized()).normalized();
      const double chord = cross(a, b) / std::max(1e-12, cross(way, b - a));
      const double out = rim && s.area > 0.0 ? rim(middle + across * center, across * way) : 0.0;
      if (out > (1.0 + kBulge) * chord) s = round_sector(std::atan2(cross(a, b), a.dot(b)), a.norm(), out, b.norm());
      sum.area += s.area, sum.moment += s.moment;
    }
    if (!(sum.area > 0.0 && mean > 0.0)) return;
    share = std::min(1.0, sum.moment / sum.area / mean);
  } else {
    center.setZero();
  }
  const Vec3 c = middle + across * center;
  for (RowPoint& r : corners) {
    Vec3 way = (share - 1.0) * (r.point - c);
    way -= normal * normal.dot(way);
    r.grip = way;
  }
}

}  // namespace brim
