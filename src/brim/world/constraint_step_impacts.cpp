// Impacts in ConstraintStep: the moment of those of balls, and their propagation one after the other.
#include <algorithm>
#include <limits>

#include "brim/response/round_impact.h"
#include "brim/world/constraint_step.h"

namespace brim {

namespace {

/// [voxels] gap that counts as contact, across which impacts are passed on.
constexpr double kTouching = 0.02;
/// Rebound relative to the fastest of a step, below which it is ignored.
constexpr double kSlightBounce = 1e-3;
/// Rounds of one impact, and impacts of one pair in a step.
constexpr int kStrikeRounds = 50, kMostStrikes = 100;

}  // namespace

Vec3 ConstraintStep::velocity_of(std::int32_t part, const Vec3& x, std::span<const double> v) const {
  if (const RigidFrame* frame = frame_of(part)) return velocity_at(part, x - frame->rigid_frame().center, v);
  const WorldPart& p = parts_[part];
  const std::int32_t source = 0;
  std::unique_ptr<Map> map;
  p.body->make_map(p.index, std::span(&x, 1), std::span(&source, 1), map);
  Vec3 u = Vec3::Zero();
  map->apply(velocities_of(p, v, first_v_), std::span(&u, 1));
  return u;
}

std::vector<std::size_t> ConstraintStep::rows_of_bodies() const {
  std::vector<std::size_t> rows(bodies_.size(), 0);
  for (const ContactPair& pair : rows_.points().pairs)
    for_movable(pair, [&](std::size_t body) { rows[body] += pair.end - pair.begin; });
  return rows;
}

bool ConstraintStep::follow_bends(std::vector<Vec3>& lambda, std::vector<double>& way) const {
  const ContactSet& points = rows_.points();
  const std::span<const double> touch = rows_.touch_times();
  const std::vector<std::size_t> rows = rows_of_bodies();
  bool alone = true;
  for (const ContactPair& pair : points.pairs)
    for (std::size_t c = pair.begin; c < pair.end; ++c)
      if (touch[c] > 0.0) for_movable(pair, [&](std::size_t body) { alone = alone && rows[body] == 1; });
  if (!alone) return false;
  for (std::size_t c = 0; c < points.size(); ++c) {
    if (!(touch[c] > 0.0)) continue;
    const Vec3 missed = -touch[c] / settings_.rows.dt * lambda[c];
    sweep_.add_response(c, missed, way);
    lambda[c] += missed;
  }
  return true;
}

void ConstraintStep::find_round_impacts(std::span<const double> v) {
  const ContactSet& points = rows_.points();
  for (std::size_t p = 0; p < points.pairs.size(); ++p) {
    const ContactPair& pair = points.pairs[p];
    if (pair.end != pair.begin + 1) continue;
    const std::size_t c = pair.begin;
    const RoundContact& round = rows_.round()[c];
    const double gap = -points.depth[c];
    if (!round.any() || !(gap > 0.0)) continue;
    const Vec3 n = rows_.normals()[c], ball_a = points.point[c] + (round.radius_a + 0.5 * gap) * n,
               ball_b = points.point[c] - (round.radius_b + 0.5 * gap) * n;
    const Vec3 velocity_a = velocity_of(pair.part_a, ball_a, v), velocity_b = velocity_of(pair.part_b, ball_b, v),
               u = velocity_a - velocity_b;
    // What comes slower closes its gap over the whole step, and has no moment of impact.
    if (!(-u.dot(n) > settings_.rows.bounce_speed)) continue;
    const Vec3 across = u - round.flat * round.flat.dot(u);
    const auto impact = find_round_impact(ball_a - ball_b, across, round.radius_a + round.radius_b, settings_.rows.dt);
    if (!impact) continue;
    // A rigid body moves with its centre, a link with that of its ball.
    const auto way = [&](std::int32_t part, const Vec3& ball) {
      return Vec3(impact->time * (frame_of(part) != nullptr ? velocity_at(part, Vec3::Zero(), v) : ball));
    };
    ways_[p] = {way(pair.part_a, velocity_a), way(pair.part_b, velocity_b)};
    // Along the axis of a side they touch where the ball is then.
    const Vec3 along = round.side_b ? Vec3(u - across) : Vec3(Vec3::Zero());
    const Vec3 at = ball_b + impact->time * (velocity_b + along) + round.radius_b * impact->normal;
    rows_.place(c, at, impact->normal, impact->gap);
  }
}

void ConstraintStep::pass_impacts_on(std::vector<double> v) {
  const std::size_t n = rows_.points().size();
  // Ignore bounces at rounding level.
  double least = 0.0;
  for (const double t : rows_.velocity_targets()) least = std::max(least, kSlightBounce * t);
  const double slow = std::max(settings_.rows.bounce_speed, least), never = -std::numeric_limits<double>::infinity();
  std::vector<double> target(n, never), grid_step(n, 0.0);  // [m]
  std::vector<std::uint8_t> between_frames(n, 0);
  for (const ContactPair& pair : rows_.points().pairs)
    for (std::size_t c = pair.begin; c < pair.end; ++c) grid_step[c] = pair.h, between_frames[c] = rigid(pair);
  std::vector<Vec3> impulse(n, Vec3::Zero());
  std::vector<std::uint8_t> hit(sweep_.groups(), 0);
  std::vector<double> hardest(n, 0.0);  // [m/s] normal velocity of each point's hardest hit, negative
  const auto velocity = [&](std::size_t c) { return offset_[c].x() + sweep_.velocity(c, v).x(); };
  // Solves one pair alone, as if nothing else touched it. @return false when nothing hits
  const auto strike = [&](std::size_t g, bool first) {
    const auto [begin, end] = sweep_.group(g);
    if (begin == end || !between_frames[begin]) return false;
    const double h = grid_step[begin];
    bool any = false;
    for (std::size_t c = begin; c < end; ++c) {
      const double u = velocity(c), gap = -rows_.points().depth[c];
      const double to = first ? rows_.velocity_targets()[c] : -rows_.restitution()[c] * u;
      // What has met in this step touches, wherever it was at its start.
      const bool touches = gap <= kTouching * h || hardest[c] < 0.0;
      const bool hits = first ? to > least : u < -slow && (touches || gap + settings_.rows.dt * u < 0.0);
      target[c] = hits ? to : never;
      if (hits) hardest[c] = std::min(hardest[c], u);
      impulse[c].setZero();
      any = any || hits;
    }
    if (any) sweep_.solve_alone(g, offset_, target, kStrikeRounds, impulse, v), hit[g] = 1;
    return any;
  };
  for (std::size_t g = 0; g < sweep_.groups(); ++g) strike(g, true);
  bool passed_on = false, any = true;
  for (int round = 0; any && round < kMostStrikes; ++round) {
    any = false;
    for (std::size_t g = 0; g < sweep_.groups(); ++g) any = strike(g, false) || any;
    passed_on = passed_on || any;
  }
  if (!passed_on) return;
  for (std::size_t g = 0; g < sweep_.groups(); ++g) {
    if (!hit[g]) continue;
    const auto [begin, end] = sweep_.group(g);
    const double h = grid_step[begin];
    for (std::size_t c = begin; c < end; ++c)
      if (rows_.velocity_targets()[c] > least || hardest[c] < 0.0 || -rows_.points().depth[c] <= kTouching * h)
        rows_.set_rebound(c, hardest[c], velocity(c), settings_.rows.dt);
  }
}

}  // namespace brim
