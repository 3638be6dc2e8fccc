#include "brim/response/solid_gap.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "brim/response/cut_model.h"
#include "brim/response/friction_radius.h"

namespace brim {

namespace {

using Vec2 = Eigen::Vector2d;
using Mat2 = Eigen::Matrix2d;

/// [h] distance of the parted solids, and the least that is enough.
constexpr double kParted = 0.5, kLeastParted = 0.1;
/// [h] way over which differences of gradients tell a curvature.
constexpr double kDifference = 0.02;
/// [1/h] curvature added to every direction, and below which a surface is flat.
constexpr double kProximal = 1e-3, kNearlyPlane = 1e-3;
/// Readings of one descent at most; [h] decrease that ends it.
constexpr int kMostReadings = 12;
constexpr double kEnough = 1e-5;
/// Rounds of parting along the normal found, and the cosine at which it is the one parted along.
constexpr int kRounds = 8;
constexpr double kSameNormal = 1.0 - 2e-5;
/// Slope of the sum at its least, and the largest that the last round may leave.
constexpr double kSlopeLeft = 0.03, kMostSlopeLeft = 0.2;
/// [h] overlap above which other normals are tried as well.
constexpr double kDeep = 0.03;
/// Least cosine of a surface's normal to that of an end.
constexpr double kAlike = 0.7;
/// [1/h] largest curvature of a row's surface: that of an edge.
constexpr double kSharp = 1.0;
/// [h] farthest from what nodes tell that the least gap is sought.
constexpr double kReach = 3.0;
/// Projections at most, and the way that ends them, [h].
constexpr int kProjections = 16;
constexpr double kStill = 0.05;
/// [1/h] mean curvature of the gap of what is round: less is flat; largest skew of it, as a share.
constexpr double kRound = 0.05, kSkew = 0.1;
/// [h] ring on which flat directions are sought; rise of the gap up to there, and change of slope on a little way on,
/// at which a direction is flat.
constexpr double kRing = 0.5, kRise = 0.15, kOn = 0.1, kTurn = 2e-4;
/// Rise on the ring, over kRise, next to which an edge may lie; bisections of the angle to it.
constexpr double kMostTip = 4.0;
constexpr int kValleySteps = 6;
/// [h] departure of the gap from its tangent at an edge; how well the edge is found; farthest that one is sought.
constexpr double kDeparture = 0.005, kFound = 0.1, kFarthestEdge = 1000.0;
/// [h] so far beside an edge the way goes along it.
constexpr double kBeside = 0.15;
/// Sine of the angle between two edges above which they meet in a corner.
constexpr double kLeastAngle = 0.3;
/// [h] ends nearer to each other are one; gap, above the least, beyond which an end says nothing yet.
constexpr double kOneEnd = 0.75, kTooFar = 0.3;
/// [h] how much nearer than its ends the least gap must be to have a row besides them.
constexpr double kDeeper = 0.01;

/// Symmetric, with eigenvalues of at least a bound.
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

/// Curvature of the surface itself from that of its distance d away from it; convex, and no sharper than an edge.
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
    : distance_a_(dynamic_cast<const ConvexDistance*>(a.solid)),
      distance_b_(dynamic_cast<const ConvexDistance*>(b.solid)),
      pose_a_(a.pose),
      pose_b_(b.pose),
      h_(h) {}

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
  Reading r = read(center);
  for (int i = 0;; ++i) {
    // No place of the region has less than the tangent foretells.
    if (r.sum() - r.slope().norm() * (radius + (r.x - center).norm()) > most) return false;
    if (i == kProjections || (r.a <= 0.0 && r.b <= 0.0)) break;
    Vec3 way = -std::max(0.0, r.a) * r.away_a - std::max(0.0, r.b) * r.away_b;
    if (r.away_a.dot(r.away_b) > 0.0 && r.a > 0.0 && r.b > 0.0) way *= 0.5;
    if (way.norm() < kStill * h_) break;
    r = read(r.x + way);
  }
  near = {};
  near.point = r.x, near.gap = r.sum(), near.normal = (r.away_b - r.away_a).normalized();
  return true;
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
    // The flatter of the two tells the direction better.
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
      found.point -= 0.5 * (parting_.least.a * parting_.least.away_a + parting_.least.b * parting_.least.away_b);
      const Mat2 turn = tangents_of(normal).transpose() * parting_.across;
      found.bend_a = surface_bend(turn * bend_a * turn.transpose(), parting_.least.a, h_);
      found.bend_b = surface_bend(turn * bend_b * turn.transpose(), parting_.least.b, h_);
      row = found;
      return true;
    }
  }
  return false;
}

bool SolidGap::walk(const Reading& flat, const Vec3& from, const Vec3& way, Edge& edge) const {
  const Vec3 slope = flat.slope();
  const auto departs = [&](const Reading& r) {
    return r.sum() - flat.sum() - slope.dot(r.x - flat.x) > kDeparture * h_;
  };
  double in = 0.0, out = h_;
  Reading far = read(from + out * way);
  while (!departs(far)) {
    if (out > kFarthestEdge * h_) return false;
    in = out;
    far = read(from + (out *= 2.0) * way);
  }
  while (out - in > kFound * h_) {
    const double t = 0.5 * (in + out);
    const Reading r = read(from + t * way);
    if (departs(r))
      out = t, far = r;
    else
      in = t;
  }
  // What lies beyond an edge has its nearest point on it.
  const Vec3 turn_a = far.away_a - flat.away_a, turn_b = far.away_b - flat.away_b;
  const bool of_a = turn_a.squaredNorm() > turn_b.squaredNorm();
  const auto across = [&](const Vec3& x) { return Vec3(x - parting_.normal * parting_.normal.dot(x)); };
  edge.x = far.x - across(of_a ? far.a * far.away_a : far.b * far.away_b);
  edge.along = parting_.normal.cross(across(of_a ? turn_a : turn_b)).normalized();
  return edge.x.allFinite() && edge.along.allFinite();
}

void SolidGap::add_end(const Reading& flat, const Vec3& x, const RowPoint& like) {
  RowPoint row = like;
  const Vec3& normal = like.normal;
  // The surfaces are flat up to there: the ways along the normal to both.
  const Vec3 d = x - flat.x;
  const double a = (flat.a + flat.away_a.dot(d)) / std::max(kAlike, -flat.away_a.dot(normal)),
               b = (flat.b + flat.away_b.dot(d)) / std::max(kAlike, flat.away_b.dot(normal));
  row.gap = a + b - parting_.part.dot(row.normal);
  row.point = x + 0.5 * (a - b) * row.normal - 0.5 * parting_.part;
  for (const RowPoint& other : ends_)
    if ((other.point - row.point).norm() < kOneEnd * h_) return;
  ends_.push_back(row);
}

Vec3 SolidGap::add_edge(const Reading& flat, const Edge& edge, const RowPoint& like) {
  // Beside the edge, where the sum has not left its tangent.
  Vec3 middle = Vec3::Zero(), in = parting_.normal.cross(edge.along);
  in *= in.dot(flat.x - edge.x) > 0.0 ? kBeside * h_ : -kBeside * h_;
  for (const double sign : {1.0, -1.0}) {
    Edge end{edge.x + in, edge.along};
    if (!walk(flat, edge.x + in, sign * edge.along, end)) continue;
    // Where the two edges meet.
    const Vec3 out = parting_.normal.cross(end.along);
    const double rate = out.dot(edge.along), t = out.dot(end.x - edge.x) / rate;
    const Vec3 x = std::abs(rate) > kLeastAngle ? Vec3(edge.x + t * edge.along) : end.x;
    add_end(flat, x, like);
    middle += 0.5 * x;
  }
  return middle;
}

bool SolidGap::find_valley(double& angle, Reading& ring) const {
  const auto way = [&](double a) { return Vec3(parting_.across * Vec2(std::cos(a), std::sin(a))); };
  double lo = angle - 0.25 * M_PI, hi = angle + 0.25 * M_PI;
  for (int i = 0; i < kValleySteps; ++i) {
    angle = 0.5 * (lo + hi);
    ring = read(parting_.least.x + kRing * h_ * way(angle));
    (ring.slope().dot(way(angle + 0.5 * M_PI)) < 0.0 ? lo : hi) = angle;
  }
  // Along an edge, exactly: across it the gradient changes.
  const Vec3 across = kRing * h_ * way(angle + 0.5 * M_PI);
  const Vec2 change = parting_.across.transpose() * (read(ring.x + across).slope() - read(ring.x - across).slope());
  if (!(change.norm() > kTurn)) return false;
  const double along = std::atan2(change.x(), -change.y());
  angle = std::cos(along - angle) > 0.0 ? along : along + M_PI;
  ring = read(parting_.least.x + kRing * h_ * way(angle));
  const Reading on = read(ring.x + kOn * h_ * way(angle));
  return ring.sum() - parting_.least.sum() < kRise * h_ &&
         std::abs((on.slope() - ring.slope()).dot(way(angle))) < kTurn;
}

void SolidGap::find_ends(const RowPoint& least) {
  constexpr int kDirections = 8;
  const auto way = [&](double angle) { return Vec3(parting_.across * Vec2(std::cos(angle), std::sin(angle))); };
  const auto beside = [&](double angle, double size) { return read(parting_.least.x + size * h_ * way(angle)); };
  // The direction in which the gap rises least: the second harmonic of its rise around.
  double c = 0.0, s = 0.0;
  for (int k = 0; k < kDirections; ++k) {
    const double angle = 2.0 * M_PI * k / kDirections, rise = beside(angle, kRing).sum() - parting_.least.sum();
    c += rise * std::cos(2.0 * angle), s += rise * std::sin(2.0 * angle);
  }
  double axis = 0.5 * std::atan2(-s, -c);
  // Along an edge, exactly: across it the gradient changes.
  const Vec2 change = parting_.across.transpose() *
                      (beside(axis + 0.5 * M_PI, 0.5 * kRing).slope() - beside(axis - 0.5 * M_PI, 0.5 * kRing).slope());
  if (change.norm() > 1e-3) axis = std::atan2(change.x(), -change.y());
  // Directions in which both surfaces are flat.
  double best = 2.0, side = 0.0, lowest = kMostTip, valley = 0.0;
  Reading face;
  bool flat[2] = {false, false};
  Reading along[2];
  for (int k = 0; k < kDirections; ++k) {
    const double angle = axis + 2.0 * M_PI * k / kDirections;
    const Reading ring = beside(angle, kRing);
    const double rise = (ring.sum() - parting_.least.sum()) / (kRise * h_);
    if (rise < lowest) lowest = rise, valley = angle;
    if (rise > 1.0) continue;
    // An edge is flat along itself only, a face across as well.
    const bool line = k % 4 == 0;
    const auto slope_change = [&](double turn) {
      const Vec3 on = way(angle) + turn * way(angle + 0.5 * M_PI),
                 d = read(ring.x + kOn * h_ * on).slope() - ring.slope();
      return (turn == 0.0 ? std::abs(d.dot(on)) : d.norm()) / kTurn;
    };
    const double turn = std::min(slope_change(0.4), slope_change(-0.4));
    if (turn <= 1.0) {
      if (rise + turn < best) best = rise + turn, side = angle, face = ring;
    } else if (line && slope_change(0.0) <= 1.0) {
      flat[k / 4] = true, along[k / 4] = ring;
    }
  }
  if (best == 2.0 && !flat[0] && !flat[1] && lowest < kMostTip && find_valley(valley, along[0]))
    flat[0] = true, axis = valley;
  Edge edge;
  RowPoint on_face;
  on_face.normal = least.normal;
  face_ = face, face_found_ = best < 2.0;
  if (face_found_) {
    // A face: one edge, and the one across from its middle; of what is round, places to the left and right besides.
    if (walk(face, face.x, way(side), edge)) {
      const Vec3 first = add_edge(face, edge, on_face);
      Vec3 in = parting_.normal.cross(edge.along);
      if (in.dot(way(side)) > 0.0) in = -in;
      if (walk(face, first, in, edge)) {
        const Vec3 middle = 0.5 * (first + add_edge(face, edge, on_face));
        const bool few = ends_.size() < 4;
        for (const double sign : {1.0, -1.0})
          if (few && walk(face, middle, sign * parting_.normal.cross(in), edge)) add_end(face, edge.x, on_face);
      }
    }
  }
  // An edge, to both sides of the least gap.
  for (int k = 0; k < 2 && (flat[0] || flat[1]); ++k) {
    const Reading& line = along[flat[0] ? 0 : 1];
    if (walk(line, flat[k] ? along[k].x : parting_.least.x, way(axis + k * M_PI), edge)) add_end(line, edge.x, least);
  }
  std::erase_if(ends_, [&](const RowPoint& r) { return r.gap > least.gap + kTooFar * h_; });
}

void SolidGap::place_friction(const Vec3& normal) {
  const auto rim = [&](const Vec3& center, const Vec3& way) {
    const Vec3 from = center + 0.5 * parting_.part;
    Edge edge;
    return walk(face_, from, way, edge) ? way.dot(edge.x - from) : 0.0;
  };
  if (face_found_)
    place_grips(ends_, normal, rim);
  else
    place_grips(ends_, normal, {});
}

bool SolidGap::round(const RowPoint& least) const {
  const double uu = double{least.bend_a[0]} + least.bend_b[0], uv = double{least.bend_a[1]} + least.bend_b[1],
               vv = double{least.bend_a[2]} + least.bend_b[2];
  const double mean = 0.5 * h_ * (uu + vv), spread = h_ * std::hypot(0.5 * (uu - vv), uv);
  const auto sharp = [&](const std::array<float, 3>& c) {
    return 0.5 * (double{c[0]} + c[2]) + std::hypot(0.5 * (double{c[0]} - c[2]), c[1]) > 0.99 * kSharp / h_;
  };
  return mean > kRound && spread < kSkew * mean && !sharp(least.bend_a) && !sharp(least.bend_b);
}

bool SolidGap::find_rows(const RowPoint& near, double widest, std::vector<RowPoint>& rows) {
  // Nowhere is the sum of the distances less than the separation along any normal.
  const double most = near.gap + 1e-3 * h_;
  RowPoint least = near;
  bool found = find_least(least, kReach * h_) && least.gap <= most;
  if (!found || least.gap < -kDeep * h_) {
    // Solids that overlap are parted along that normal that takes the least way, which need not be the first.
    Parting best = parting_;
    parting_.part.setZero();
    const Reading r = read(near.point);
    for (const Vec3& normal :
         {r.away_b, Vec3(-r.away_a), Vec3((pose_a_.translation - pose_b_.translation).normalized())}) {
      RowPoint other = near;
      other.normal = normal;
      if (!find_least(other, kReach * h_) || other.gap > most || (found && other.gap <= least.gap)) continue;
      found = true, least = other, best = parting_;
    }
    parting_ = best;
  }
  if (!found) return false;
  if (least.gap > widest) return true;
  ends_.clear();
  face_found_ = false;
  if (!round(least)) find_ends(least);
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
