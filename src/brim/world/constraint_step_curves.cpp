// Rows on curved surfaces in ConstraintStep: they act with the normal of the middle of the step.
#include <algorithm>
#include <cmath>
#include <utility>

#include "brim/math/rotation.h"
#include "brim/world/constraint_step.h"

namespace brim {

namespace {

/// [voxels] gap that counts as contact, and largest rise of the surface over half a step; least change of a normal that
/// counts.
constexpr double kHeld = 0.1, kMostRise = 0.2, kLeastTurn = 1e-9;
/// [1/h] curvatures: least and largest of a gap that is round, largest of a plane.
constexpr double kRound = 0.02, kEdge = 0.5, kPlane = 1e-3;
/// [voxels] farthest that the point rolls in half a step.
constexpr double kFarthestRoll = 5.0;
/// [voxels] way along the normal in half a step of what stays on the surface.
constexpr double kSlow = 0.02;

std::array<float, 3> packed(const Mat3& bend, const Vec3& n) {
  const Eigen::Matrix<double, 3, 2> t = tangents_of(n);
  const Eigen::Matrix2d m = t.transpose() * bend * t;
  return {static_cast<float>(m(0, 0)), static_cast<float>(m(0, 1)), static_cast<float>(m(1, 1))};
}

/// Least and largest curvature across a normal, [1/m].
std::pair<double, double> curvatures_of(const Mat3& bend, const Vec3& n) {
  const Eigen::Matrix<double, 3, 2> t = tangents_of(n);
  const Eigen::Matrix2d m = t.transpose() * bend * t;
  const double mean = 0.5 * (m(0, 0) + m(1, 1)), spread = std::hypot(0.5 * (m(0, 0) - m(1, 1)), m(0, 1));
  return {mean - spread, mean + spread};
}

}  // namespace

void ConstraintStep::follow_curves(std::span<const double> v) {
  const ContactSet& points = rows_.points();
  lift_.assign(points.size(), 0.0), follows_.assign(points.pairs.size(), kNot);
  const double half = 0.5 * settings_.rows.dt;
  for (std::size_t p = 0; p < points.pairs.size(); ++p) {
    const ContactPair& pair = points.pairs[p];
    if (pair.end != pair.begin + 1 || !rigid(pair) || rows_.off_nodes(p)) continue;
    const std::size_t c = pair.begin;
    const Constraint::Bend& bend = rows_.bends()[c];
    // On a plane nothing turns.
    if (pair.h * std::min(bend.a.norm(), bend.b.norm()) < kPlane) continue;
    if (std::abs(points.depth[c]) > kHeld * pair.h) continue;
    const auto [least, most] = curvatures_of(bend.a + bend.b, rows_.normals()[c]);
    if (!(pair.h * least > kRound && pair.h * most < kEdge)) continue;
    const auto motion_of = [&](std::int32_t part) {
      const Vec3 center = frame_of(part)->rigid_frame().center, velocity = velocity_at(part, Vec3::Zero(), v);
      RigidMotion m;
      m.none = false;
      m.center = center, m.shift = half * velocity;
      // The spin: what a point at unit distance has more than the centre, axis by axis.
      for (int i = 0; i < 3; ++i) {
        const Vec3 more = velocity_at(part, Vec3::Unit(i), v) - velocity;
        m.rotation += 0.5 * half * Vec3::Unit(i).cross(more);
      }
      m.turn = rotation_from_vector(m.rotation).toRotationMatrix() - Mat3::Identity();
      return m;
    };
    const RigidMotion a = motion_of(pair.part_a), b = motion_of(pair.part_b);
    const Vec3 n = rows_.normals()[c], x = points.point[c];
    const auto approach = [&](const Vec3& at, const Vec3& normal, const Vec3& way_a, const Vec3& way_b) {
      return normal.dot(velocity_at(pair.part_a, at - a.center - way_a, v) -
                        velocity_at(pair.part_b, at - b.center - way_b, v));
    };
    const double before = approach(x, n, Vec3::Zero(), Vec3::Zero());
    if (-before > settings_.rows.bounce_speed) continue;
    const RowPoint then = moved({x, n, -double{points.depth[c]}, Vec3::Zero(), packed(bend.a, n), packed(bend.b, n)}, a,
                                b, pair.h, kFarthestRoll);
    const double lift = before - approach(then.point, then.normal, a.shift, b.shift);
    if (!(std::abs(lift) * half < kMostRise * pair.h)) continue;
    if (!((then.normal - n).norm() > kLeastTurn)) continue;
    follows_[p] = std::abs(before) * half < kSlow * pair.h ? kAlong : kAbove;
    lift_[c] = lift;
    ways_[p] = {a.shift, b.shift};
    rows_.place(c, then.point, then.normal, -points.depth[c]);
  }
}

std::vector<std::uint8_t> ConstraintStep::go_along_curves(std::vector<Vec3>& lambda, std::vector<double>& way) const {
  const ContactSet& points = rows_.points();
  std::vector<std::uint8_t> along(bodies_.size(), 0);
  const std::vector<std::size_t> rows = rows_of_bodies();
  for (std::size_t p = 0; p < points.pairs.size(); ++p) {
    if (follows_[p] == kNot) continue;
    const ContactPair& pair = points.pairs[p];
    const std::size_t c = pair.begin;
    if (!(lambda[c].x() > 0.0)) continue;
    bool alone = follows_[p] == kAlong;
    for_movable(pair, [&](std::size_t body) { alone = alone && rows[body] == 1 && !mixed_[body]; });
    if (alone) {
      for_movable(pair, [&](std::size_t body) {
        for (std::size_t i = first_v_[body]; i < first_v_[body + 1]; ++i) way[i] *= 0.5;
        along[body] = 1;
      });
      lambda[c] *= 0.5;
    } else if (lift_[c] != 0.0) {
      std::vector<double> answer(width_, 0.0);
      sweep_.add_response(c, Vec3::UnitX(), answer);
      const Vec3 back = -lift_[c] / sweep_.velocity(c, answer).x() * Vec3::UnitX();
      sweep_.add_response(c, back, way);
      lambda[c] += back;
    }
  }
  return along;
}

}  // namespace brim
