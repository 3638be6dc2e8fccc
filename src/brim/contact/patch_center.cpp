#include "brim/contact/patch_center.h"

#include <cmath>

namespace brim {

namespace {

/// [voxels] higher differences of the gap up to which it counts as a parabola.
constexpr double kParabola = 0.06;
/// Least share that the gap's slopes on both sides of what is round have of each other. Beside an edge one side is
/// level.
constexpr double kAlike = 0.2;
/// [1/voxels] curvature that is flat: half of a shift is made there.
constexpr double kFlat = 0.005;
/// [voxels] half the width of a patch that is one place of touch; farthest that it is moved.
constexpr double kNarrow = 3.0, kFarthest = 0.75;
/// [voxels] gap by which a point lies beside the place of touch.
constexpr double kBeside = 0.5;
/// Weight of a node that waits, for solids that do not overlap yet.
constexpr double kWaiting = 1e-9;

struct Parabola {
  double slope = 0.0, curvature = 0.0;  ///< [-], [1/m]
  bool fits = false;
  bool round = false;  ///< it rises to both sides alike, facets or not
};

/// The gap along a line through x.
Parabola along(const CubeSide& a, const CubeSide& b, const Vec3& x, const Vec3& e, double h) {
  const auto gap = [&](double t) { return gap_between(a, b, x + t * h * e); };
  const double m2 = gap(-1.0), m1 = gap(-0.5), p0 = gap(0.0), p1 = gap(0.5), p2 = gap(1.0);
  const double third = p2 - 2.0 * p1 + 2.0 * m1 - m2, fourth = p2 - 4.0 * p1 + 6.0 * p0 - 4.0 * m1 + m2;
  const double left = m2 - m1, right = p2 - p1;
  return {(p2 - m2) / (2.0 * h), (p2 - 2.0 * p0 + m2) / (h * h),
          std::abs(third) < kParabola * h && std::abs(fourth) < kParabola * h,
          left > kAlike * right && right > kAlike * left};
}

struct Principal {
  Vec3 major, minor;
};

/// The directions across n in which the gap bends most and least at x.
Principal principal_directions(const CubeSide& a, const CubeSide& b, const Vec3& x, const Vec3& n, double h) {
  int across = 0;
  n.cwiseAbs().minCoeff(&across);
  Vec3 e = Vec3::Unit(across);
  e = (e - n * n.dot(e)).normalized();
  const Vec3 f = n.cross(e), diagonal = (e + f).normalized();
  const double bend_e = along(a, b, x, e, h).curvature, bend_f = along(a, b, x, f, h).curvature;
  const double mixed = along(a, b, x, diagonal, h).curvature - 0.5 * (bend_e + bend_f);
  const double turn = 0.5 * std::atan2(2.0 * mixed, bend_e - bend_f);
  const Vec3 major = std::cos(turn) * e + std::sin(turn) * f;
  return {major, n.cross(major)};
}

/// The centre of the overlap and the direction across it.
struct Touch {
  double weight = 0.0;  ///< none where nothing overlaps, or has a direction
  Vec3 x, n;
};

/// @param least  weight of what does not overlap
Touch middle_of(std::span<const Contact> contacts, double least) {
  Touch t{0.0, Vec3::Zero(), Vec3::Zero()};
  for (const Contact& c : contacts) {
    const double w = std::max(least, double{c.overlap});
    t.weight += w, t.x += w * c.point, t.n += w * (c.gradient_a - c.gradient_b).cast<double>();
  }
  if (!(t.weight > 0.0) || !(t.n.norm() > 0.0)) return {};
  t.x /= t.weight, t.n.normalize();
  return t;
}

/// 0 for a face, towards 1 for what is round.
double bent(const Parabola& p, double h) { return p.curvature / (p.curvature + kFlat / h); }

}  // namespace

double roundness(const CubeSide& a, const CubeSide& b, double h, std::span<const Contact> contacts) {
  const Touch touch = middle_of(contacts, kWaiting);
  if (!(touch.weight > 0.0)) return 1.0;
  const auto at = [&](const Vec3& x) {
    const Principal v = principal_directions(a, b, x, touch.n, h);
    double most = 0.0;
    for (const Vec3& e : {v.major, v.minor}) {
      const Parabola p = along(a, b, x, e, h);
      if (p.round && p.curvature > 0.0) most = std::max(most, bent(p, h));
    }
    return most;
  };
  // Where there are several places of touch, their middle lies beside all of them.
  const Contact* deepest = &contacts.front();
  for (const Contact& c : contacts)
    if (c.depth > deepest->depth) deepest = &c;
  return at(gap_between(a, b, touch.x) + deepest->depth < kBeside * h ? touch.x : deepest->point);
}

void center_on_least_gap(const CubeSide& a, const CubeSide& b, double h, std::span<Contact> contacts) {
  const auto [weight, x, n] = middle_of(contacts, 0.0);
  if (!(weight > 0.0)) return;
  const auto [major, minor] = principal_directions(a, b, x, n, h);
  for (const Vec3& v : {major, minor}) {
    const Parabola p = along(a, b, x, v, h);
    if (!p.fits || !(p.curvature > 0.0) || std::abs(p.slope) > kFarthest * h * p.curvature) continue;
    bool narrow = true;
    for (const Contact& c : contacts)
      narrow = narrow && (!(c.overlap > 0.0f) || std::abs(v.dot(c.point - x)) < kNarrow * h);
    if (!narrow) continue;
    const double share = bent(p, h), least = v.dot(x) - p.slope / p.curvature;
    for (Contact& c : contacts) c.point += share * (least - v.dot(c.point)) * v;
  }
}

}  // namespace brim
