// Preparation of ConstraintStep: bodies of the rows, maps of the points, responses of the bodies.
#include <algorithm>

#include "brim/world/constraint_step.h"

namespace brim {

namespace {

/// Largest number of a body's contacts with a full response matrix: it is stored and swept at quadratic cost.
constexpr std::size_t kMostDirect = 400;

}  // namespace

void ConstraintStep::mark_bodies(const ContactSet& contacts, std::span<const ConstraintPair> pairs,
                                 const GatheredRows& gathered) {
  if (rigid_.size() != bodies_.size()) {
    rigid_.resize(bodies_.size());
    for (std::size_t b = 0; b < bodies_.size(); ++b) rigid_[b] = dynamic_cast<const RigidFrame*>(bodies_[b].get());
  }
  held_.assign(bodies_.size(), 0), touched_.assign(bodies_.size(), 0), mixed_.assign(bodies_.size(), 0);
  mapped_ = false, solids_ = true;
  coupled_ = Islands(bodies_.size());
  const auto couple = [&](std::int32_t a, std::int32_t b) {
    if (!is_fixed(parts_[a]) && !is_fixed(parts_[b])) coupled_.join(parts_[a].body_index, parts_[b].body_index);
  };
  for (std::size_t p = 0; p < contacts.pairs.size(); ++p) {
    const ContactPair& pair = contacts.pairs[p];
    if (pair.begin == pair.end) continue;
    couple(pair.part_a, pair.part_b);
    const bool general = pairs[p].constrained && !rigid(pair);
    mapped_ = mapped_ || general, solids_ = solids_ && !general;
    for (const std::int32_t part : {pair.part_a, pair.part_b}) {
      if (is_fixed(parts_[part])) continue;
      (pairs[p].constrained ? held_ : mixed_)[parts_[part].body_index] = 1;
      if (general) touched_[parts_[part].body_index] = 1;
    }
  }
  for (const PairRows& pair : gathered.pairs) {
    couple(pair.part_a, pair.part_b);
    const bool general = !rigid(pair.part_a, pair.part_b);
    mapped_ = mapped_ || general;
    for (const std::int32_t part : {pair.part_a, pair.part_b}) {
      if (is_fixed(parts_[part])) continue;
      held_[parts_[part].body_index] = 1;
      if (general) touched_[parts_[part].body_index] = 1;
    }
  }
}

void ConstraintStep::build_maps() {
  const ContactSet& points = rows_.points();
  if (std::ranges::all_of(ways_, [](const Ways& w) { return w.a == Vec3::Zero() && w.b == Vec3::Zero(); })) {
    maps_.build(parts_, points, first_v_);
  } else {
    // The bodies stand where they are now: what they will touch then is back along their ways.
    ContactSet now = points;
    now.link_point_b = now.point;
    for (std::size_t p = 0; p < points.pairs.size(); ++p)
      for (std::size_t c = points.pairs[p].begin; c < points.pairs[p].end; ++c)
        now.point[c] -= ways_[p].a, now.link_point_b[c] -= ways_[p].b;
    maps_.build(parts_, now, first_v_);
  }
  gripped_.resize(0), gripped_.pairs.clear(), grip_of_.clear();
  for (ContactPair pair : points.pairs) {
    const std::size_t first = grip_of_.size();
    for (std::size_t c = pair.begin; c < pair.end; ++c)
      if (apart_[c]) grip_of_.push_back(c);
    if (grip_of_.size() == first) continue;
    pair.begin = first, pair.end = grip_of_.size();
    gripped_.pairs.push_back(pair);
  }
  gripped_.resize(grip_of_.size());
  for (std::size_t i = 0; i < grip_of_.size(); ++i) {
    gripped_.point[i] = rows_.grips()[grip_of_[i]];
    gripped_.source_a[i] = points.source_a[grip_of_[i]], gripped_.source_b[i] = points.source_b[grip_of_[i]];
  }
  grip_maps_.build(parts_, gripped_, first_v_);
}

RigidPairRows::Side ConstraintStep::side_of(std::int32_t part, const Vec3& way) const {
  const WorldPart& p = parts_[part];
  const RigidFrame::Frame f = frame_of(part)->rigid_frame();
  const auto body = static_cast<std::size_t>(p.body_index);
  if (is_fixed(p)) return {RigidPairRows::kFixed, f.center + way, 0.0, Mat3::Zero()};
  return {first_v_[body], f.center + way, f.inverse_mass, f.inverse_inertia};
}

void ConstraintStep::choose_inverses() {
  std::vector<std::size_t> rows(bodies_.size(), 0);
  for (const ContactPair& pair : rows_.points().pairs)
    if (pair.begin < pair.end && !rigid(pair))
      for_bodies(pair, [&](std::size_t b, bool, bool) { rows[b] += pair.end - pair.begin; });
  bool direct = mapped_;
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    direct = direct && !(held_[b] && mixed_[b]) &&
             !(touched_[b] && (rows[b] > kMostDirect || first_v_[b + 1] - first_v_[b] > BodyInverses::kMostFactored));
  const auto exact = [&] {
    for (std::size_t b = 0; b < bodies_.size(); ++b)
      if (!knows(b)) return false;
    return true;
  };
  std::vector<std::uint8_t> wanted(touched_);
  if (direct) std::replace(wanted.begin(), wanted.end(), std::uint8_t{1}, std::uint8_t{2});
  inverses_.begin(bodies_, first_v_, wanted);
  exact_ = exact();
  // A single body without factor makes the whole solve inexact.
  if (direct && !exact_) inverses_.begin(bodies_, first_v_, touched_);
  if (!exact_) find_known();
}

void ConstraintStep::find_known() {
  Islands islands = join_rows();
  std::vector<std::uint8_t> doubtful(bodies_.size(), 0);
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    if (!knows(b)) doubtful[islands.first_of(static_cast<std::int32_t>(b))] = 1;
  const ContactSet& points = rows_.points();
  known_.resize(points.size());
  // Islands without doubtful points share number 0 with the first: they are no more in the way.
  std::vector<std::uint8_t> refined(bodies_.size(), 0);
  for (const ContactPair& p : points.pairs) {
    const std::uint8_t known = doubtful[islands.first_of(moving_body(p))] == 0;
    for (std::size_t c = p.begin; c < p.end; ++c) known_[c] = known;
    if (!known && p.begin < p.end) refined[coupled_.first_of(moving_body(p))] = 1;
  }
  islands_ = 0;
  std::vector<std::int32_t> number(bodies_.size(), 0);
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    if (refined[b]) number[b] = static_cast<std::int32_t>(islands_++);
  island_of_body_.resize(bodies_.size()), island_.assign(points.size(), 0);
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    island_of_body_[b] = number[coupled_.first_of(static_cast<std::int32_t>(b))];
  for (const ContactPair& p : points.pairs)
    for (std::size_t c = p.begin; c < p.end; ++c) island_[c] = island_of_body_[moving_body(p)];
}

template <class F>
void ConstraintStep::for_bodies(const ContactPair& pair, const F& f) const {
  const std::size_t a = static_cast<std::size_t>(parts_[pair.part_a].body_index),
                    b = static_cast<std::size_t>(parts_[pair.part_b].body_index);
  if (touched_[a]) f(a, true, a == b);
  if (touched_[b] && a != b) f(b, false, true);
}

void ConstraintStep::find_forces(std::size_t p, std::size_t c, std::size_t body, bool side_a, bool side_b) {
  const ContactSet& points = rows_.points();
  const ContactPair& pair = points.pairs[p];
  const std::size_t n = first_v_[body + 1] - first_v_[body];
  for (int axis = 0; axis < 3; ++axis) {
    force_[axis].assign(n, 0.0), answer_[axis].resize(n);
    const Vec3& at = axis > 0 && apart_[c] ? rows_.grips()[c] : points.point[c];
    const bool anew = axis == 0 || (axis == 1 && apart_[c]) || (side_a && side_b);
    const auto add_side = [&](std::int32_t part, std::int32_t source, const Vec3& way, double sign) {
      std::unique_ptr<Map>& map = map_[part];
      const Vec3 now = at - way;
      if (anew) parts_[part].body->make_map(parts_[part].index, std::span(&now, 1), std::span(&source, 1), map);
      const Vec3 f = sign * frame_[c].row(axis).transpose();
      map->apply_transpose(std::span(&f, 1), force_[axis]);
    };
    if (side_a) add_side(pair.part_a, points.source_a[c], ways_[p].a, 1.0);
    if (side_b) add_side(pair.part_b, points.source_b[c], ways_[p].b, -1.0);
    bodies_[body]->filter(force_[axis]);
  }
}

void ConstraintStep::assemble() {
  choose_inverses();
  first_mode_.assign(1, first_v_.back());
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    first_mode_.push_back(first_mode_.back() + static_cast<std::size_t>(inverses_.modes(b)));
  sweep_.clear();
  if (map_.size() != parts_.size()) map_.clear();  // a part that is added may take the place of another
  map_.resize(parts_.size());
  direct_.begin(bodies_.size(), first_mode_.back());
  const ContactSet& points = rows_.points();
  for (std::size_t p = 0; p < points.pairs.size(); ++p) {
    const ContactPair& pair = points.pairs[p];
    for (std::size_t c = pair.begin; c < pair.end && !rigid(pair); ++c)
      for_bodies(pair, [&](std::size_t b, bool side_a, bool side_b) {
        if (!inverses_.factored(b)) return;
        find_forces(p, c, b, side_a, side_b);
        direct_.add(b, c, force_);
      });
  }
  direct_.solve(inverses_, first_v_);
  width_ = first_mode_.back() + direct_.size();
  for (std::size_t p = 0; p < points.pairs.size(); ++p) {
    const ContactPair& pair = points.pairs[p];
    const std::size_t n = pair.end - pair.begin;
    if (n == 0) continue;
    if (rigid(pair) && (exact_ || known_[pair.begin]))
      sweep_.add_pair(side_of(pair.part_a, ways_[p].a), side_of(pair.part_b, ways_[p].b),
                      std::span(points.point).subspan(pair.begin, n), rows_.grips().subspan(pair.begin, n),
                      std::span<const Mat3>(frame_).subspan(pair.begin, n), rows_.friction()[pair.begin]);
    else
      for (std::size_t c = pair.begin; c < pair.end; ++c) rigid(pair) ? add_rigid_row(p, c) : add_row(p, c);
  }
  if (exact_) return;
  sweep_.begin_learning(width_, island_);
  width_ += ProjectedGaussSeidel::kLearned * std::max<std::size_t>(1, islands_);
}

void ConstraintStep::add_rigid_row(std::size_t p, std::size_t c) {
  const ContactPair& pair = rows_.points().pairs[p];
  entries_.clear();
  const auto add = [&](std::int32_t part, const Vec3& way, double sign) {
    const RigidPairRows::Side side = side_of(part, way);
    if (side.first == RigidPairRows::kFixed) return;
    Mat3 turn;  // columns: torques of unit impulses along the rows
    for (int k = 0; k < 3; ++k)
      turn.col(k) =
          ((k == 0 ? rows_.points().point[c] : rows_.grips()[c]) - side.center).cross(frame_[c].row(k).transpose());
    const Mat3 spin = side.inverse_inertia * turn;
    for (int i = 0; i < 3; ++i)
      entries_.push_back({side.first + static_cast<std::size_t>(i), sign * frame_[c].col(i),
                          sign * side.inverse_mass * frame_[c].col(i)});
    for (int i = 0; i < 3; ++i)
      entries_.push_back({side.first + 3 + static_cast<std::size_t>(i), sign * turn.row(i).transpose(),
                          sign * spin.row(i).transpose()});
  };
  add(pair.part_a, ways_[p].a, 1.0);
  add(pair.part_b, ways_[p].b, -1.0);
  sweep_.add(entries_, rows_.friction()[c]);
}

void ConstraintStep::add_row(std::size_t p, std::size_t c) {
  entries_.clear();
  for_bodies(rows_.points().pairs[p], [&](std::size_t b, bool side_a, bool side_b) {
    if (inverses_.factored(b)) return direct_.append(b, c, entries_);
    find_forces(p, c, b, side_a, side_b);
    for (int axis = 0; axis < 3; ++axis) inverses_.local(b, force_[axis], answer_[axis]);
    for (std::size_t i = 0; i < force_[0].size(); ++i) {
      const Vec3 row(force_[0][i], force_[1][i], force_[2][i]), answer(answer_[0][i], answer_[1][i], answer_[2][i]);
      if (row != Vec3::Zero() || answer != Vec3::Zero()) entries_.push_back({first_v_[b] + i, row, answer});
    }
    const int modes = inverses_.modes(b);
    if (modes == 0) return;
    Eigen::MatrixXd row(modes, 3), answer(modes, 3);
    for (int axis = 0; axis < 3; ++axis) {
      row.col(axis) = inverses_.to_modes(b, force_[axis]);
      answer.col(axis) = inverses_.mode_response(b, row.col(axis));
    }
    for (int k = 0; k < modes; ++k)
      entries_.push_back({first_mode_[b] + static_cast<std::size_t>(k), row.row(k), answer.row(k)});
  });
  sweep_.add(entries_, rows_.friction()[c]);
}

}  // namespace brim
