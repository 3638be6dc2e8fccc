#include "brim/contact/patch_center.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace brim {

namespace {

/// [voxels] higher differences of the gap up to which it counts as a parabola.
constexpr double kParabola = 0.06;
/// Smallest ratio of the gap's slopes on both sides of a round contact. Beside an edge one side is level.
constexpr double kAlike = 0.2;
/// [1/voxels] curvature of a flat surface: half of the shift is applied there.
constexpr double kFlat = 0.005;
/// [voxels] half width up to which a patch is a single contact; largest shift of it.
constexpr double kNarrow = 3.0, kFarthest = 0.75;
/// [voxels] excess of the gap at a point that is not the contact point.
constexpr double kBeside = 0.5;
/// [voxels] from a rim to where a line of contact is examined.
constexpr double kInside = 1.25;
/// [voxels] largest excess of the gap there; smallest decrease of the higher differences.
constexpr double kAlikeGap = 0.25, kClearly = 0.03;
/// Newton steps to the smallest gap.
constexpr int kNewton = 5;
/// Smallest slope of a distance for which its surface is searched.
constexpr double kFacing = 0.9;
/// Weight of a node without overlap, for solids that do not overlap yet.
constexpr double kWaiting = 1e-9;

struct Parabola {
  double slope = 0.0, curvature = 0.0;  ///< [-], [1/m]
  double misfit = 0.0;                  ///< [voxels] the larger of the higher differences
  bool fits = false;
  bool round = false;  ///< it rises about equally on both sides, faceted or not
};

/// The gap along a line through x.
Parabola along(const CubeSide& a, const CubeSide& b, const Vec3& x, const Vec3& e, double h) {
  const auto gap = [&](double t) { return gap_between(a, b, x + t * h * e); };
  const double m2 = gap(-1.0), m1 = gap(-0.5), p0 = gap(0.0), p1 = gap(0.5), p2 = gap(1.0);
  const double third = p2 - 2.0 * p1 + 2.0 * m1 - m2, fourth = p2 - 4.0 * p1 + 6.0 * p0 - 4.0 * m1 + m2;
  const double left = m2 - m1, right = p2 - p1;
  const double misfit = std::max(std::abs(third), std::abs(fourth)) / h;
  return {(p2 - m2) / (2.0 * h), (p2 - 2.0 * p0 + m2) / (h * h), misfit,
          misfit<kParabola, left> kAlike * right && right > kAlike * left};
}

struct Principal {
  Vec3 major, minor;
};

/// The tangential directions in which the gap at x has most and least curvature.
/// @param both  use both diagonals, so that higher-order terms of the gap do not rotate the directions. With one
///              diagonal they rotate off the line of an edge, along which the contact then looks less round
Principal principal_directions(const CubeSide& a, const CubeSide& b, const Vec3& x, const Vec3& n, double h,
                               bool both) {
  int across = 0;
  n.cwiseAbs().minCoeff(&across);
  Vec3 e = Vec3::Unit(across);
  e = (e - n * n.dot(e)).normalized();
  const Vec3 f = n.cross(e), up = (e + f).normalized(), down = (e - f).normalized();
  const double bend_e = along(a, b, x, e, h).curvature, bend_f = along(a, b, x, f, h).curvature;
  const double bend_up = along(a, b, x, up, h).curvature;
  const double mixed = both ? 0.5 * (bend_up - along(a, b, x, down, h).curvature) : bend_up - 0.5 * (bend_e + bend_f);
  const double turn = 0.5 * std::atan2(2.0 * mixed, bend_e - bend_f);
  const Vec3 major = std::cos(turn) * e + std::sin(turn) * f;
  return {major, n.cross(major)};
}

struct Place {
  Vec3 x;
  std::array<Vec3, 2> directions;  ///< of most and least curvature of the gap there
};

/// x, or the nearby point at which the gap is closer to a parabola in both directions: above the rim at the end of a
/// line of contact it is none, and the line's direction cannot be determined.
Place smooth_place(const CubeSide& a, const CubeSide& b, const Vec3& x, const Vec3& n, double h) {
  const auto directions = [&](const Vec3& at) {
    const Principal v = principal_directions(a, b, at, n, h, true);
    return std::array{v.major, v.minor};
  };
  const auto misfit = [&](const Place& p) {
    return std::max(along(a, b, p.x, p.directions[0], h).misfit, along(a, b, p.x, p.directions[1], h).misfit);
  };
  const auto round_at = [&](const Place& p) {
    return std::ranges::any_of(p.directions, [&](const Vec3& v) {
      const Parabola q = along(a, b, p.x, v, h);
      return q.fits && q.round && q.curvature > 0.0;
    });
  };
  Place best{x, directions(x)};
  double least = misfit(best) - kClearly;
  if (!(least > 0.0)) return best;
  const auto [e, f] = best.directions;
  const double most = gap_between(a, b, x) + kAlikeGap * h;
  for (int k = 0; k < 8; ++k) {
    const double turn = k * 0.25 * std::numbers::pi;
    const Vec3 at = x + kInside * h * (std::cos(turn) * e + std::sin(turn) * f);
    if (gap_between(a, b, at) > most) continue;
    const Place beside{at, directions(at)};
    const double is = misfit(beside);
    if (is < least && round_at(beside)) best = beside, least = is;
  }
  return best;
}

/// The centre of the overlap and its normal.
struct Touch {
  double weight = 0.0;  ///< zero when nothing overlaps, or there is no normal
  Vec3 x, n;
};

/// @param least  weight of nodes without overlap
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

/// 0 for a face, towards 1 for a round contact.
double bent(const Parabola& p, double h) { return p.curvature / (p.curvature + kFlat / h); }

/// Position of the smallest gap along a line through x, by Newton steps: a round gap is only locally a parabola. [m]
double least_along(const CubeSide& a, const CubeSide& b, const Vec3& x, const Vec3& v, double h) {
  double t = 0.0;
  for (int k = 0; k < kNewton; ++k) {
    const Parabola p = along(a, b, x + t * v, v, h);
    if (!(p.curvature > 0.0)) break;
    t -= std::clamp(p.slope / p.curvature, -h, h);
  }
  return v.dot(x) + t;
}

/// A direction in which the gap is a parabola, and the position of its minimum along it.
struct Bend {
  Vec3 v = Vec3::Zero();
  double least = 0.0, share = 0.0;  ///< [m], [-]
};

/// Gradient of the distance to a solid.
Vec3 slope_of(const CubeSide& side, const Vec3& x, double h) {
  const auto distance = [&](const Vec3& at) { return side.solid->rough_distance(side.pose.to_local(at)); };
  Vec3 slope;
  for (int i = 0; i < 3; ++i) {
    const Vec3 step = 0.25 * h * Vec3::Unit(i);
    slope[i] = (distance(x + step) - distance(x - step)) / (0.5 * h);
  }
  return slope;
}

/// Curvature of the distance to a solid along a direction, [1/m].
double bend_of(const CubeSide& side, const Vec3& x, const Vec3& v, double h) {
  const auto distance = [&](double t) { return side.solid->rough_distance(side.pose.to_local(x + t * h * v)); };
  return (distance(1.0) - 2.0 * distance(0.0) + distance(-1.0)) / (h * h);
}

/// Moves points by a share of the way onto the tangent plane of a solid's surface next to x.
void carry_to_surface(const CubeSide& side, const Vec3& x, double h, double share, std::span<Contact> contacts) {
  const Vec3 slope = slope_of(side, x, h);
  if (!(slope.norm() > kFacing)) return;
  const double distance = side.solid->rough_distance(side.pose.to_local(x));
  const Vec3 n = slope.normalized(), surface = x - distance / slope.norm() * n;
  for (Contact& c : contacts) c.point += share * n.dot(surface - c.point) * n;
}

/// True when all overlapping nodes lie within a few voxels of x along v.
bool is_narrow(std::span<const Contact> contacts, const Vec3& x, const Vec3& v, double h) {
  return std::ranges::all_of(
      contacts, [&](const Contact& c) { return !(c.overlap > 0.0f) || std::abs(v.dot(c.point - x)) < kNarrow * h; });
}

void move_points(const Bend& bend, std::span<Contact> contacts) {
  for (Contact& c : contacts) c.point += bend.share * (bend.least - bend.v.dot(c.point)) * bend.v;
}

/// Moves the points of a round contact to the contact point. @return false when it is not round
bool roll(const CubeSide& a, const CubeSide& b, const CubeSide& moving, double carried, Touch touch, double h,
          std::span<Contact> contacts) {
  if (!(touch.weight > 0.0) && !contacts.empty()) {
    // Nothing overlaps yet: use the node closest to overlap.
    const auto nearest = std::ranges::max_element(contacts, {}, &Contact::overlap);
    touch = middle_of({&*nearest, 1}, kWaiting);
  }
  if (!(touch.weight > 0.0)) return false;
  // Normal of the fixed solid: the mean gradient of a few nodes would be tilted.
  const CubeSide& still = &moving == &a ? b : a;
  const Vec3 fixed = slope_of(still, touch.x, h);
  const auto [x, directions] = smooth_place(a, b, touch.x, fixed.norm() > kFacing ? fixed.normalized() : touch.n, h);
  double share = 0.0;
  Vec3 least_gap = x;
  std::array<Bend, 2> bends;
  for (std::size_t k = 0; k < 2; ++k) {
    const Vec3& v = directions[k];
    const Parabola p = along(a, b, x, v, h);
    if (!p.fits || !p.round || !(p.curvature > 0.0) || !is_narrow(contacts, x, v, h)) continue;
    const double least = least_along(a, b, x, v, h);
    if (std::abs(least - v.dot(touch.x)) > kFarthest * h) continue;
    // The remaining error for a ball of four voxels on a plane is a lever of 4e-4 of a voxel. In a close-fitting hollow
    // the contact is an arc, with a different normal at each point.
    const double hollow = std::max(0.0, std::abs(bend_of(still, x, v, h)) - p.curvature);
    const double times = p.curvature / (kFlat / h + hollow);
    bends[k] = {v, least, times * times / (1.0 + times * times)};
    least_gap += (least - v.dot(x)) * v;
    share = std::max(share, bends[k].share);
  }
  for (const Bend& bend : bends) move_points(bend, contacts);
  if (share > 0.0) carry_to_surface(moving, least_gap, h, carried * share, contacts);
  return share > 0.0;
}

}  // namespace

double rounder(const CubeSide& one, const CubeSide& other, double h, std::span<const Contact> contacts) {
  const Touch touch = middle_of(contacts, kWaiting);
  if (!(touch.weight > 0.0)) return 0.0;
  const auto bend = [&](const CubeSide& side) {
    const Principal v = principal_directions(side, side, touch.x, touch.n, h, false);
    return std::max(std::abs(bend_of(side, touch.x, v.major, h)), std::abs(bend_of(side, touch.x, v.minor, h)));
  };
  const double bent = bend(one), sum = bent + bend(other);
  return sum > 0.0 ? 2.0 * bent / sum - 1.0 : 0.0;
}

double roundness(const CubeSide& a, const CubeSide& b, double h, std::span<const Contact> contacts) {
  const Touch touch = middle_of(contacts, kWaiting);
  if (!(touch.weight > 0.0)) return 1.0;
  const auto at = [&](const Vec3& x) {
    const Principal v = principal_directions(a, b, x, touch.n, h, false);
    double most = 0.0;
    for (const Vec3& e : {v.major, v.minor}) {
      const Parabola p = along(a, b, x, e, h);
      if (p.round && p.curvature > 0.0) most = std::max(most, bent(p, h));
    }
    return most;
  };
  // With several contact points their centre lies beside all of them.
  const Contact* deepest = &contacts.front();
  for (const Contact& c : contacts)
    if (c.depth > deepest->depth) deepest = &c;
  return at(gap_between(a, b, touch.x) + deepest->depth < kBeside * h ? touch.x : deepest->point);
}

void center_on_least_gap(const CubeSide& a, const CubeSide& b, const CubeSide& moving, double carried, double h,
                         std::span<Contact> contacts) {
  const Touch touch = middle_of(contacts, 0.0);
  if (roll(a, b, moving, carried, touch, h, contacts) || !(touch.weight > 0.0)) return;
  // A contact that is not round rests on an edge.
  const auto [major, minor] = principal_directions(a, b, touch.x, touch.n, h, false);
  for (const Vec3& v : {major, minor}) {
    const Parabola p = along(a, b, touch.x, v, h);
    if (!p.fits || !(p.curvature > 0.0) || !is_narrow(contacts, touch.x, v, h)) continue;
    if (std::abs(p.slope) > kFarthest * h * p.curvature) continue;
    move_points({v, v.dot(touch.x) - p.slope / p.curvature, bent(p, h)}, contacts);
  }
}

}  // namespace brim
