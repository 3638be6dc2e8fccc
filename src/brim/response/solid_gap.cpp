#include "brim/response/solid_gap.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "brim/response/closest_points.h"
#include "brim/response/cut_model.h"

namespace brim {

namespace {

using Mat2 = Eigen::Matrix2d;
using Vec2 = Eigen::Vector2d;

/// [h] distance of the displaced solids, and the smallest that is sufficient.
constexpr double kParted = 0.5, kLeastParted = 0.1;
/// [h] distance over which differences of gradients give a curvature.
constexpr double kDifference = 0.02;
/// [1/h] curvature added to every direction, and below which a surface is flat.
constexpr double kProximal = 1e-3, kNearlyPlane = 1e-3;
/// Maximum number of readings of one descent; [h] decrease that ends it.
constexpr int kMostReadings = 12;
constexpr double kEnough = 1e-5;
/// [1/h] curvature of directions of which half of the rest is gone; [h] largest and least step, and how many.
constexpr double kHardlyBent = 0.02, kMostRest = 0.1, kNoRest = 1e-4;
constexpr int kRestReadings = 3;
/// Rounds of displacing along the normal found, and the cosine at which it equals the previous one.
constexpr int kRounds = 8;
constexpr double kSameNormal = 1.0 - 2e-5;
/// Slope of the sum accepted at its minimum, and the largest accepted after the last round.
constexpr double kSlopeLeft = 0.03, kMostSlopeLeft = 0.2;
/// [h] overlap above which other normals are tried as well.
constexpr double kDeep = 0.03;
/// [1/h] largest curvature of a row's surface, assigned to an edge.
constexpr double kSharp = 1.0;
/// [h] largest distance of the smallest gap from the one given by nodes.
constexpr double kReach = 3.0;
/// Maximum number of projections, and the displacement that ends them, [h].
constexpr int kProjections = 16;
constexpr double kStill = 0.05;
/// [h] size of the region from which on a slope of the sum may hide a far smaller gap; such a difference; accuracy of
/// the distance of long solids.
constexpr double kLongRegion = 24.0, kFarBelow = 0.1, kClosest = 0.01;
/// [1/h] smallest mean curvature of the gap of a round contact; largest relative skew of it.
constexpr double kRound = 0.05, kSkew = 0.1;
/// Directions in which a round gap is read where it has risen to kTooFar; smallest part of that rise. A ball of one
/// step rises by 0.8 of it, as the solids are parted; beside its ends a capsule, 22 degrees off its axis, by 0.6 at
/// most.
constexpr int kRingReadings = 8;
constexpr double kStaysRound = 0.7;
/// [h] how much smaller than at its ends the smallest gap must be to get a row of its own.
constexpr double kDeeper = 0.01;

/// Symmetric matrix with eigenvalues raised to at least a bound.
Mat2 at_least(const Mat2& m, double bound) {
  const double mean = 0.5 * (m(0, 0) + m(1, 1)), half = 0.5 * (m(0, 0) - m(1, 1)), off = 0.5 * (m(0, 1) + m(1, 0)),
               spread = std::hypot(half, off);
  const double hi = std::max(mean + spread, bound), lo = std::max(mean - spread, bound);
  const double middle = 0.5 * (hi + lo), x = spread > 0.0 ? 0.5 * (hi - lo) / spread : 0.0;
  Mat2 r;
  r << middle + x * half, x * off, x * off, middle - x * half;
  return r;
}

std::array<float, 3> pack(const Mat2& m) {
  return {static_cast<float>(m(0, 0)), static_cast<float>(m(0, 1)), static_cast<float>(m(1, 1))};
}

/// Curvature of the surface from that of its distance at a distance d; convex, and at most that of an edge.
std::array<float, 3> surface_bend(const Mat2& c, double d, double h) {
  Mat2 m = at_least(c, 0.0);
  const double size = 0.5 * (m(0, 0) + m(1, 1)) + std::hypot(0.5 * (m(0, 0) - m(1, 1)), m(0, 1));
  if (!(size * h > kNearlyPlane)) return {};
  m /= std::max(1e-3, 1.0 - d * size);
  m *= std::min(1.0, kSharp / (size / std::max(1e-3, 1.0 - d * size) * h));
  return pack(m);
}

}  // namespace

SolidGap::SolidGap(const CubeSide& a, const CubeSide& b, double h)
    : distance_a_(a.solid != nullptr ? a.solid->convex() : nullptr),
      distance_b_(b.solid != nullptr ? b.solid->convex() : nullptr),
      pose_a_(a.pose),
      pose_b_(b.pose),
      h_(h),
      farthest_(kReach * h) {}

SolidGap::Reading SolidGap::read(const Vec3& x) const {
  readings_ += 2;
  Reading r;
  r.x = x;
  Vec3 g;
  r.a = distance_a_->distance_and_gradient(pose_a_.to_local(x - parting_.part), g);
  r.away_a = pose_a_.rotation * g;
  r.b = distance_b_->distance_and_gradient(pose_b_.to_local(x), g);
  r.away_b = pose_b_.rotation * g;
  return r;
}

bool SolidGap::approach(const Aabb& region, double most, RowPoint& near) {
  parting_.part.setZero();
  const Vec3 center = region.center();
  const double radius = 0.5 * region.extent().norm();
  farthest_ = std::max(kReach * h_, 2.0 * radius);
  Reading r = read(center);
  for (int i = 0;; ++i) {
    // No point of the region is below the tangent.
    if (r.sum() - r.slope().norm() * (radius + (r.x - center).norm()) > most) return false;
    if (i == kProjections || (r.a <= 0.0 && r.b <= 0.0)) break;
    Vec3 way = -std::max(0.0, r.a) * r.away_a - std::max(0.0, r.b) * r.away_b;
    if (r.away_a.dot(r.away_b) > 0.0 && r.a > 0.0 && r.b > 0.0) way *= 0.5;
    if (way.norm() < kStill * h_) break;
    r = read(r.x + way);
  }
  near = {};
  near.point = r.x, near.gap = r.sum(), near.normal = (r.away_b - r.away_a).normalized();
  if (farthest_ > kLongRegion * h_ && r.slope().norm() * farthest_ > kFarBelow * h_) approach_long(near);
  return true;
}

void SolidGap::approach_long(RowPoint& near) const {
  // Overlapping solids are moved apart along the guessed normal.
  for (double s = kParted * h_; s < farthest_; s *= 4.0) {
    PlacedConvex a{distance_a_, pose_a_};
    const PlacedConvex b{distance_b_, pose_b_};
    a.pose.translation += s * near.normal;
    Vec3 on_a = a.support(-near.normal), on_b = b.support(near.normal);
    if (!on_b.allFinite())
      on_b = on_a;  // a half-space: the other solid's lowest point
    else if (!on_a.allFinite())
      on_a = on_b;
    else if (!closest_points(a, b, near.normal, kClosest * h_, on_a, on_b))
      continue;
    const Vec3 normal = on_a == on_b ? near.normal : Vec3((on_a - on_b).normalized());
    near.point = 0.5 * (on_a + on_b) - 0.5 * s * near.normal;
    near.gap = read(near.point).sum();
    near.normal = normal;
    return;
  }
}

SolidGap::Reading SolidGap::part_at(const RowPoint& row, double more) {
  parting_.normal = row.normal, parting_.across = tangents_of(parting_.normal);
  double s = std::max(0.0, kParted * h_ - row.gap) + more;
  Reading r;
  for (int i = 0; i < 3; ++i) {
    parting_.part = s * parting_.normal;
    r = read(row.point + 0.5 * parting_.part);
    // Half-way between both.
    if (std::abs(r.a - r.b) > 0.1 * h_) r = read(r.x + 0.5 * (r.a - r.b) * parting_.normal);
    if (std::min(r.a, r.b) > 0.5 * kLeastParted * h_) break;
    s += kParted * h_ - 2.0 * std::min(r.a, r.b);
  }
  return r;
}

void SolidGap::bend(const Reading& r, Mat2& a, Mat2& b) const {
  const double step = kDifference * h_;
  for (int k = 0; k < 2; ++k) {
    const Reading beside = read(r.x + step * parting_.across.col(k));
    a.col(k) = parting_.across.transpose() * (beside.away_a - r.away_a) / step;
    b.col(k) = parting_.across.transpose() * (beside.away_b - r.away_b) / step;
  }
}

SolidGap::Reading SolidGap::descend(const Reading& first, const Mat2& curvature, double reach) const {
  CutModel model(at_least(curvature, kProximal / h_));
  Reading best = first, now = first;
  Vec2 at = Vec2::Zero(), next = Vec2::Zero();
  for (int i = 1;; ++i) {
    model.add({next, parting_.across.transpose() * now.slope(), now.sum()});
    if (now.sum() < best.sum()) best = now, at = next;
    if (i == kMostReadings) return best;
    double foretold = 0.0;
    next = model.least(at, foretold);
    if (!(best.sum() - foretold > kEnough * h_) || !next.allFinite()) return best;
    if (next.norm() > reach) next *= reach / next.norm();
    if ((next - at).norm() < 1e-4 * h_) return best;
    now = read(best.x + parting_.across * (next - at) + 0.5 * (best.a - best.b) * parting_.normal);
  }
}

SolidGap::Reading SolidGap::settle(Reading r, const Mat2& bend) const {
  const double flat = kHardlyBent / h_;
  const Mat2 inverse = (bend * bend + flat * flat * Mat2::Identity()).inverse() * bend;
  for (int k = 0; k < kRestReadings; ++k) {
    Vec2 way = -(inverse * (parting_.across.transpose() * r.slope()));
    const double size = way.norm();
    if (size < kNoRest * h_) break;
    if (size > kMostRest * h_) way *= kMostRest * h_ / size;
    const Reading there = read(r.x + parting_.across * way);
    if (there.sum() > r.sum()) break;
    r = there;
  }
  return r;
}

bool SolidGap::find_least(RowPoint& row, double reach) {
  RowPoint found = row;
  double more = 0.0;
  for (int round = 0; round < kRounds; ++round) {
    const Reading first = part_at(found, more);
    if (!(std::min(first.a, first.b) > 0.0)) return false;
    Mat2 bend_a, bend_b;
    bend(first, bend_a, bend_b);
    parting_.least = descend(first, bend_a + bend_b, reach);
    if (parting_.least.x != first.x) bend(parting_.least, bend_a, bend_b);
    // The flatter of the two gives the more accurate direction.
    const double a = bend_a.norm() + kNearlyPlane / h_, b = bend_b.norm() + kNearlyPlane / h_;
    const bool room = std::min(parting_.least.a, parting_.least.b) > 0.0;
    const Vec3 normal =
        room ? Vec3((a * parting_.least.away_b - b * parting_.least.away_a).normalized()) : parting_.normal;
    found.point = parting_.least.x - 0.5 * parting_.part;
    if (!room) {
      if (parting_.least.sum() < kParted * h_) more += kParted * h_;
      continue;
    }
    found.gap = parting_.least.sum() - parting_.part.dot(normal);
    found.normal = normal;
    const double rest = (parting_.across.transpose() * parting_.least.slope()).norm();
    if ((rest < kSlopeLeft && normal.dot(parting_.normal) > kSameNormal) ||
        (round + 1 == kRounds && rest < kMostSlopeLeft)) {
      const Reading r = settle(parting_.least, bend_a + bend_b);
      parting_.rest = r.x - parting_.least.x;
      found.point += parting_.rest - 0.5 * (r.a * r.away_a + r.b * r.away_b);
      const Mat2 turn = tangents_of(normal).transpose() * parting_.across;
      found.bend_a = surface_bend(turn * bend_a * turn.transpose(), parting_.least.a, h_);
      found.bend_b = surface_bend(turn * bend_b * turn.transpose(), parting_.least.b, h_);
      row = found;
      return true;
    }
  }
  return false;
}

bool SolidGap::round(const RowPoint& least) const {
  const double uu = double{least.bend_a[0]} + least.bend_b[0], uv = double{least.bend_a[1]} + least.bend_b[1],
               vv = double{least.bend_a[2]} + least.bend_b[2];
  const double mean = 0.5 * h_ * (uu + vv), spread = h_ * std::hypot(0.5 * (uu - vv), uv);
  const auto sharp = [&](const std::array<float, 3>& c) {
    return 0.5 * (double{c[0]} + c[2]) + std::hypot(0.5 * (double{c[0]} - c[2]), c[1]) > 0.99 * kSharp / h_;
  };
  if (!(mean > kRound) || !(spread < kSkew * mean) || sharp(least.bend_a) || sharp(least.bend_b)) return false;
  // As far as rows may stand: the lowest point of a capsule that lies nearly flat is just beside one of its ends, on a
  // ball, and its other end is as near as that to what carries it.
  const double ring = std::sqrt(2.0 * kTooFar / mean) * h_;
  for (int k = 0; k < kRingReadings; ++k) {
    const double angle = 2.0 * M_PI * k / kRingReadings;
    const Vec3 way = parting_.across * Vec2(std::cos(angle), std::sin(angle));
    if (read(parting_.least.x + ring * way).sum() - parting_.least.sum() < kStaysRound * kTooFar * h_) return false;
  }
  return true;
}

bool SolidGap::find_rows(const RowPoint& near, double widest, std::vector<RowPoint>& rows) {
  // The sum of the distances is nowhere less than the separation along any normal.
  const double most = near.gap + 1e-3 * h_;
  RowPoint least = near;
  bool found = find_least(least, farthest_) && least.gap <= most;
  if (!found || least.gap < -kDeep * h_) {
    // Overlapping solids are separated along the normal of smallest displacement, which need not be the first.
    Parting best = parting_;
    parting_.part.setZero();
    const Reading r = read(near.point);
    for (const Vec3& normal :
         {r.away_b, Vec3(-r.away_a), Vec3((pose_a_.translation - pose_b_.translation).normalized())}) {
      RowPoint other = near;
      other.normal = normal;
      if (!find_least(other, farthest_) || other.gap > most || (found && other.gap <= least.gap)) continue;
      found = true, least = other, best = parting_;
    }
    parting_ = best;
  }
  if (!found) return false;
  if (least.gap > widest) return true;
  ends_.clear();
  face_found_ = false;
  if (!round(least)) find_ends(least);
  for (RowPoint& r : ends_) r.point += parting_.rest;
  place_friction(least.normal);
  bool deeper = true;
  if (ends_.size() >= 2)
    for (const RowPoint& r : ends_) deeper = deeper && least.gap < r.gap - kDeeper * h_;
  if (deeper) {
    std::erase_if(ends_, [&](const RowPoint& r) { return (r.point - least.point).norm() < kOneEnd * h_; });
    rows.push_back(least);
  }
  rows.insert(rows.end(), ends_.begin(), ends_.end());
  return true;
}

}  // namespace brim
