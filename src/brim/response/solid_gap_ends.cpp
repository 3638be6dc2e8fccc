#include <algorithm>
#include <array>
#include <cmath>

#include "brim/response/friction_radius.h"
#include "brim/response/solid_gap.h"

// The ends of the contact region, where both surfaces are flat in some direction.

namespace brim {

namespace {

/// Smallest cosine of a surface's normal to that of an end.
constexpr double kAlike = 0.7;
/// [h] radius of the ring on which flat directions are searched; largest rise of the gap up to there; further step, and
/// largest change of slope over it, for a flat direction.
constexpr double kRing = 0.5, kRise = 0.15, kOn = 0.1, kTurn = 2e-4;
/// Rise on the ring, relative to kRise, up to which an edge may lie nearby; bisections of the angle to it.
constexpr double kMostTip = 4.0;
constexpr int kValleySteps = 6;
/// [h] departure of the gap from its tangent at an edge; accuracy of the edge; largest distance searched.
constexpr double kDeparture = 0.005, kFound = 0.1, kFarthestEdge = 1e5;
/// [h] distance beside an edge at which the search follows it.
constexpr double kBeside = 0.15;
/// Sine of the angle between two edges above which they meet in a corner.
constexpr double kLeastAngle = 0.3;
/// Width of a face at its ends over the distance between them from which on it has no other points; over the width in
/// its middle, from which on it is no round face, and below which two ends are one.
constexpr double kSlender = 0.7, kRoundFace = 0.7, kNarrow = 0.4;

}  // namespace

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
  // Beyond an edge the nearest point is on the edge.
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
  // The surfaces are flat up to there: distances along the normal to both.
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
  // Beside the edge, where the sum still follows its tangent.
  Vec3 middle = Vec3::Zero(), in = parting_.normal.cross(edge.along);
  in *= in.dot(flat.x - edge.x) > 0.0 ? kBeside * h_ : -kBeside * h_;
  for (const double sign : {1.0, -1.0}) {
    Edge end{edge.x + in, edge.along};
    if (!walk(flat, edge.x + in, sign * edge.along, end)) continue;
    // Intersection of the two edges.
    const Vec3 out = parting_.normal.cross(end.along);
    const double rate = out.dot(edge.along), t = out.dot(end.x - edge.x) / rate;
    const Vec3 x = std::abs(rate) > kLeastAngle ? Vec3(edge.x + t * edge.along) : end.x;
    add_end(flat, x, like);
    middle += 0.5 * x;
  }
  return middle;
}

void SolidGap::add_sides(const Reading& face, const std::array<Vec3, 2>& middles, std::size_t of_first,
                         const RowPoint& like) {
  const Vec3 apart = middles[1] - middles[0], center = 0.5 * (middles[0] + middles[1]),
             across = parting_.normal.cross(apart).normalized();
  const std::array<std::pair<std::size_t, std::size_t>, 2> pairs{{{0, of_first}, {of_first, ends_.size()}}};
  std::array<double, 2> width{};
  for (int k = 0; k < 2; ++k)
    if (const auto [begin, end] = pairs[k]; end == begin + 2)
      width[k] = (ends_[begin].point - ends_[begin + 1].point).norm();
  if (std::min(width[0], width[1]) > kSlender * apart.norm()) return;
  Edge left, right;
  if (!walk(face, center, across, left) || !walk(face, center, -across, right)) return;
  const double whole = across.dot(left.x - right.x);
  if (ends_.size() == 4 && std::max(width[0], width[1]) > kRoundFace * whole) return;
  // On a round rim two ends lie close together, and the face would stand on a line.
  for (int k = 1; k >= 0; --k) {
    if (!(width[k] > 0.0 && width[k] < kNarrow * whole)) continue;
    const auto first = ends_.begin() + static_cast<std::ptrdiff_t>(pairs[k].first);
    ends_.erase(first, first + 2);
    add_end(face, middles[k], like);
  }
  add_end(face, left.x, like);
  add_end(face, right.x, like);
}

bool SolidGap::find_valley(double& angle, Reading& ring) const {
  const auto way = [&](double a) { return Vec3(parting_.across * Vec2(std::cos(a), std::sin(a))); };
  double lo = angle - 0.25 * M_PI, hi = angle + 0.25 * M_PI;
  for (int i = 0; i < kValleySteps; ++i) {
    angle = 0.5 * (lo + hi);
    ring = read(parting_.least.x + kRing * h_ * way(angle));
    (ring.slope().dot(way(angle + 0.5 * M_PI)) < 0.0 ? lo : hi) = angle;
  }
  // Exact direction of the edge: the gradient changes perpendicular to it.
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
  // The direction of least rise of the gap: second harmonic of the rise around the ring.
  double c = 0.0, s = 0.0;
  for (int k = 0; k < kDirections; ++k) {
    const double angle = 2.0 * M_PI * k / kDirections, rise = beside(angle, kRing).sum() - parting_.least.sum();
    c += rise * std::cos(2.0 * angle), s += rise * std::sin(2.0 * angle);
  }
  double axis = 0.5 * std::atan2(-s, -c);
  // Exact direction of the edge: the gradient changes perpendicular to it.
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
    // An edge is flat only along itself, a face also across.
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
    // A face: one edge, and the opposite one from its middle.
    if (walk(face, face.x, way(side), edge)) {
      const Vec3 first = add_edge(face, edge, on_face);
      const std::size_t of_first = ends_.size();
      Vec3 in = parting_.normal.cross(edge.along);
      if (in.dot(way(side)) > 0.0) in = -in;
      if (walk(face, first, in, edge)) {
        const Vec3 second = add_edge(face, edge, on_face);
        add_sides(face, {first, second}, of_first, on_face);
      }
    }
  }
  // An edge: its ends on both sides of the smallest gap.
  for (int k = 0; k < 2 && (flat[0] || flat[1]); ++k) {
    const Reading& line = along[flat[0] ? 0 : 1];
    if (walk(line, flat[k] ? along[k].x : parting_.least.x, way(axis + k * M_PI), edge)) add_end(line, edge.x, least);
  }
  // No two points are closer along the normal than those of the smallest gap: an end below it was led too far by a
  // slope.
  std::erase_if(ends_, [&](const RowPoint& r) { return std::abs(r.gap - least.gap) > kTooFar * h_; });
  for (RowPoint& r : ends_) r.gap = std::max(r.gap, least.gap);
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

}  // namespace brim
