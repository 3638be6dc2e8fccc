#include "brim/world/links.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "brim/body/distance_bound.h"
#include "brim/body/material_points.h"
#include "brim/body/posed_shape.h"
#include "brim/core/error.h"

namespace brim {

namespace {

/// First number of what memory holds of links: what others keep starts otherwise (Levels, Edits, Sleep,
/// ReferencePoses).
constexpr double kLinksMark = -0.125;
constexpr double kOlderMark = -0.25;  ///< of runs from before Levels had it; theirs is longer (Levels::read)
/// Distance of the two ends, over the step of the grid, up to which they are at the same place.
constexpr double kSamePlace = 1e-3;

/// Gap between two sides, over the step, up to which they are taken to be at the same place: it closes as
/// exp(−t / kClosing).
constexpr double kSeam = 0.5;
constexpr double kClosing = 0.1;  // [s]
/// The same of a joint, whose two sides have been placed where their matter is nearest to each other.
constexpr double kJointSeam = 3.0;
/// Turns in which each side follows the other to a place that both have matter at.
constexpr int kTogether = 12;
/// [voxels] Distance of the points that a joint needs to hold a direction.
constexpr double kLeastSpread = 0.1;

/// The part of a side that is meant, or the one whose box lies nearest to x.
int choose_part(std::span<const WorldPart> parts, const std::vector<int>& mine, int wanted, const Vec3& x) {
  if (wanted >= static_cast<int>(mine.size()))
    throw InputError(
        fmt::format("part {} is not allowed; '{}' has {}", wanted, parts[mine[0]].body->name(), mine.size()));
  if (wanted >= 0) return mine[wanted];
  int best = mine[0];
  double least = std::numeric_limits<double>::infinity();
  for (const int p : mine) {
    const Aabb box = parts[p].body->bounds(parts[p].index);
    const double d = (x - x.cwiseMax(box.lo).cwiseMin(box.hi)).norm();
    if (d < least) least = d, best = p;
  }
  return best;
}

/// Some of the points, spread: each is the farthest from those before it.
std::vector<Vec3> spread_of(const std::vector<Vec3>& x, std::size_t most) {
  if (x.size() <= most) return x;
  std::vector<double> distance(x.size(), std::numeric_limits<double>::infinity());
  std::vector<Vec3> out;
  std::size_t next = 0;
  while (out.size() < most) {
    out.push_back(x[next]);
    for (std::size_t i = 0; i < x.size(); ++i) distance[i] = std::min(distance[i], (x[i] - out.back()).squaredNorm());
    next = static_cast<std::size_t>(std::max_element(distance.begin(), distance.end()) - distance.begin());
    if (!(distance[next] > 0.0)) break;
  }
  return out;
}

bool is_solid(const WorldPart& p) {
  const auto* bound = dynamic_cast<const DistanceBound*>(p.body);
  return bound != nullptr && bound->solid(p.index) != nullptr;
}

bool carries_any(const WorldPart& p) { return is_solid(p) || dynamic_cast<const MaterialPoints*>(p.body) != nullptr; }

/// Shortest distance from a hinge's axis that its angle is read at, as a share of the axis' held length.
constexpr double kArm = 0.02;

/// Distance of the third held point from the line through the others, as a share of their distance: the smaller one of
/// the two sides.
double least_arm(std::span<const Vec3> a, std::span<const Vec3> b) {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& x : {a, b}) {
    const Vec3 line = x[0] - x[1], r = x[2] - 0.5 * (x[0] + x[1]);
    if (!(line.squaredNorm() > 0.0)) return 0.0;
    least = std::min(least, line.cross(r).norm() / line.squaredNorm());
  }
  return least;
}

/// A quarter of the smallest extent of either side, where it has one. @param b  none: space
double span_of(const LinkJoint& joint, const WorldPart& a, const WorldPart* b) {
  if (joint.span > 0.0) return joint.span;
  double span = std::numeric_limits<double>::infinity();
  for (const WorldPart* part : {&a, b}) {
    const double least = part != nullptr ? part->body->bounds(part->index).extent().minCoeff() : 0.0;
    if (std::isfinite(least) && least > 0.0) span = std::min(span, 0.25 * least);
  }
  return std::isfinite(span) ? span : 4.0 * a.h;
}

double worst_gap(const MatterPoints& a, const MatterPoints& b) {
  double worst = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, (a.positions()[i] - b.positions()[i]).norm());
  return worst;
}

/// Value and rate that a drive aims at over a sub-step, as JointForces has it.
std::pair<double, double> aim_of(const JointDrive& d, double time, double dt) {
  if (d.keys.empty()) return {d.target, d.target_velocity};
  const auto at = [&](double t) {
    if (t <= d.keys.front().time) return d.keys.front().value;
    if (t >= d.keys.back().time) return d.keys.back().value;
    std::size_t i = 1;
    while (d.keys[i].time < t) ++i;
    const TargetKey &a = d.keys[i - 1], &b = d.keys[i];
    return a.value + (b.value - a.value) * (t - a.time) / (b.time - a.time);
  };
  return {at(time + dt), (at(time + dt) - at(time)) / dt};
}

std::vector<Vec3> points_in(const Body& body, const std::function<bool(const Vec3&)>& region) {
  std::vector<Vec3f> vertex(body.display().vertices);
  body.display_positions(vertex);
  std::vector<Vec3> x;
  for (const Vec3f& v : vertex)
    if (region(v.cast<double>())) x.push_back(v.cast<double>());
  if (x.empty()) throw InputError(fmt::format("no point of '{}' lies in the region", body.name()));
  return x;
}

}  // namespace

int Links::add(const Attachment& given, std::span<const WorldPart> parts, const Side& a, const Side& b,
               double ramp_voxels, double time) {
  const auto prefixed = [&](const std::string& what) {
    return InputError(fmt::format("attachment '{}': {}", given.name, what));
  };
  for (const auto& [what, value] : {std::pair{"stiffness", given.stiffness}, std::pair{"damping", given.damping},
                                    std::pair{"length", given.length.value_or(0.0)}})
    if (!(value >= 0.0) || !std::isfinite(value))
      throw prefixed(fmt::format("{} {} is not allowed; must be a number from 0", what, value));
  if (!(given.break_force > 0.0)) throw prefixed("break_force must be above 0");
  if (given.point.has_value() + static_cast<bool>(given.region) + given.joint.has_value() != 1)
    throw prefixed("exactly one of a point, a region and a joint says what is held");
  if (given.joint && (given.to_point || given.length || given.pulls_only))
    throw prefixed("to_point, length and pulls_only are not for joints");
  if (given.region && given.to_point) throw prefixed("a region is held where it is; to_point is for a point");
  if (given.motion && !b.parts.empty()) throw prefixed("only what is held to space can be moved by keyframes");
  for (const Link& l : links_)
    if (l.given.name == given.name) throw prefixed("there is another one of that name");
  if (a.parts.empty()) throw prefixed("the body has no part to hold");
  try {
    Link link;
    link.given = given;
    link.start = time;
    std::vector<Vec3> x;
    if (given.region) {
      const Body& body = *parts[a.parts[0]].body;
      x = points_in(body, given.region);
      link.part_a = choose_part(parts, a.parts, given.part, x[0]);
      if (is_solid(parts[link.part_a])) x = spread_of(x, kMostOfSolid);
    } else {
      const Vec3 place = given.joint ? given.joint->position : *given.point;
      link.part_a = choose_part(parts, a.parts, given.part, place);
      x = {place};
    }
    const WorldPart& pa = parts[link.part_a];
    link.body_a = pa.body_index;
    if (given.joint) {
      if (!b.parts.empty()) link.part_b = choose_part(parts, b.parts, given.to_part, x[0]);
      x = joint_points(*given.joint, span_of(*given.joint, pa, link.part_b < 0 ? nullptr : &parts[link.part_b]));
    }
    std::vector<Vec3> y = x;
    if (given.to_point) y = {*given.to_point};
    double mass_b = std::numeric_limits<double>::infinity();
    if (b.parts.empty()) {
      link.a = MatterPoints::of_part(pa, ramp_voxels * pa.h, a.q, x);
      if (!given.to_point) y.assign(link.a.positions().begin(), link.a.positions().end());
      link.b = MatterPoints::of_space(y);
    } else {
      if (!given.joint) link.part_b = choose_part(parts, b.parts, given.to_part, y[0]);
      const WorldPart& pb = parts[link.part_b];
      link.body_b = pb.body_index;
      mass_b = pb.body->mass();
      // What carries any point follows what does not.
      const bool b_first = !given.to_point && carries_any(pa) && !carries_any(pb);
      const auto bind_a = [&] { link.a = MatterPoints::of_part(pa, ramp_voxels * pa.h, a.q, x); };
      const auto bind_b = [&] { link.b = MatterPoints::of_part(pb, ramp_voxels * pb.h, b.q, y); };
      const auto same = [](const MatterPoints& m) {
        return std::vector<Vec3>(m.positions().begin(), m.positions().end());
      };
      if (b_first) {
        bind_b();
        x = same(link.b);
        bind_a();
      } else {
        bind_a();
        if (!given.to_point) y = same(link.a);
        bind_b();
        // Where neither carries any point, each follows the other in turn; the turn that brings them nearest counts.
        std::vector<Vec3> nearest = x;
        double least = worst_gap(link.a, link.b), now = least;
        for (int i = 1; i < kTogether && given.joint && least > kSamePlace * pa.h; ++i) {
          x = same(link.b);
          bind_a();
          y = same(link.a);
          bind_b();
          now = worst_gap(link.a, link.b);
          if (now < least) least = now, nearest = x;
        }
        if (given.joint && now > least) {
          x = nearest;
          bind_a();
          y = same(link.a);
          bind_b();
        }
      }
    }
    for (const Vec3& p : link.b.positions()) link.middle += p / static_cast<double>(link.b.size());
    choose_held(link, pa.h);
    const double least = std::min(pa.body->mass(), mass_b), most = std::max(pa.body->mass(), mass_b);
    link.mass = std::isinf(most) ? least : std::min(most, kUnequal * least);
    if (!std::isfinite(least)) throw InputError("neither side can move");
    links_.push_back(std::move(link));
  } catch (const InputError& e) {
    throw prefixed(e.what());
  }
  return static_cast<int>(links_.size()) - 1;
}

bool Links::needs_space() const {
  return std::any_of(links_.begin(), links_.end(), [](const Link& l) { return l.part_b < 0; });
}

std::vector<Vec3> Links::joint_points(const LinkJoint& joint, double span) {
  const Vec3& p = joint.position;
  if (joint.kind == JointKind::Ball) return {p};
  if (joint.kind == JointKind::Fixed) {
    const double s = span / std::sqrt(3.0);
    return {p + s * Vec3(1, 1, 1), p + s * Vec3(1, -1, -1), p + s * Vec3(-1, 1, -1), p + s * Vec3(-1, -1, 1)};
  }
  if (!(joint.axis.norm() > 1e-12)) throw InputError("the axis must be a direction of some length");
  const Vec3 n = joint.axis.normalized();
  Eigen::Index least = 0;
  n.cwiseAbs().minCoeff(&least);
  const Vec3 side = n.cross(Vec3::Unit(least)).normalized();
  if (joint.kind == JointKind::Revolute) return {p + span * n, p - span * n, p + span * side};
  return {p + span * n, p - span * n, p + span * side, p - span * side, p};
}

void Links::choose_held(Link& link, double h) {
  const double same_place = kSamePlace * h;
  const std::size_t n = link.a.size();
  const auto hold = [&](std::size_t point, Hold how, double share) {
    link.held.push_back({point, how, share, 0.0, Vec3::Zero()});
  };
  if (!link.given.joint) {
    const bool line = link.given.to_point || link.given.length || link.given.pulls_only;
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3 gap = link.a.positions()[i] - link.b.positions()[i];
      const double apart = gap.norm(), length = link.given.length.value_or(apart);
      // A line needs two ends; what is at the same place is held there.
      const bool along =
          line ? link.given.pulls_only || std::max(length, apart) > same_place : n == 1 && apart > kSeam * h;
      if (!line && !along && apart > kSeam * h) continue;  // of a region: the other side has no matter there
      hold(i, along ? Hold::Along : Hold::Point, 1.0);
      link.held.back().length = length;
      if (!along) link.held.back().gap = gap;
    }
    if (link.held.empty()) throw InputError("the two sides have no matter in common in the region");
    for (Held& held : link.held) held.share = 1.0 / static_cast<double>(link.held.size());
    return;
  }
  const LinkJoint& j = *link.given.joint;
  const bool slides = j.kind == JointKind::Prismatic, turns = j.kind == JointKind::Revolute;
  if (const double apart = worst_gap(link.a, link.b); apart > kJointSeam * h)
    throw InputError(fmt::format(
        "the two sides have no matter within {:.3g} m ({:.0f} voxels) of each other at the joint (theirs is "
        "{:.3g} m apart); give a smaller span or another place",
        kJointSeam * h, kJointSeam, apart));
  const auto apart_by = [&](std::span<const Vec3> x, std::size_t i) { return (x[i] - x[0]).norm(); };
  const std::size_t ends = j.kind == JointKind::Fixed ? n : turns || slides ? 2 : 0;
  double spread = ends > 0 ? 0.0 : std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < ends; ++i)
    spread = std::max(spread, std::min(apart_by(link.a.positions(), i), apart_by(link.b.positions(), i)));
  if (spread < kLeastSpread * h)
    throw InputError(fmt::format("the bodies have too little matter about the {}; give a larger span",
                                 j.kind == JointKind::Fixed ? "joint" : "axis"));
  const std::size_t held = turns ? 2 : slides ? 4 : n;
  for (std::size_t i = 0; i < held; ++i) {
    hold(i, slides ? Hold::Across : Hold::Point, 1.0 / static_cast<double>(held));
    const Vec3 gap = link.a.positions()[i] - link.b.positions()[i];
    if (gap.norm() > same_place) link.held.back().gap = gap;
  }
  link.zero = coordinate(link).value;
  const bool acts = j.drive.stiffness > 0.0 || j.drive.damping > 0.0 || j.damping > 0.0;
  const bool limited = std::isfinite(j.lower) || std::isfinite(j.upper);
  if ((acts || limited) && !turns && !slides)
    throw InputError("only joints that turn or slide about an axis have limits, damping and drives");
  if ((acts || limited) && turns && least_arm(link.a.positions(), link.b.positions()) < kArm)
    throw InputError(
        "a drive, damping or limit of a revolute joint needs matter beside its axis on both sides, and one has none at "
        "the place that is held (a rod about its own axis has none at all); turn the axis, or hold it by bodies that "
        "are wider there");
  if (acts) hold(n - 1, Hold::Drive, 1.0);
  if (std::isfinite(j.lower)) hold(n - 1, Hold::Lower, 1.0);
  if (std::isfinite(j.upper)) hold(n - 1, Hold::Upper, 1.0);
}

Links::Coordinate Links::coordinate(const Link& link) {
  Coordinate c;
  const JointKind kind = link.given.joint ? link.given.joint->kind : JointKind::Ball;
  if (kind != JointKind::Revolute && kind != JointKind::Prismatic) return c;
  const auto a = link.a.positions(), b = link.b.positions();
  c.axis = (b[0] - b[1]).normalized();
  if (kind == JointKind::Prismatic) {
    c.value = c.axis.dot(a[4] - b[4]) - link.zero;
    c.n = c.axis;
    c.point = a[4];
    return c;
  }
  const auto arm = [&](std::span<const Vec3> x) {
    const Vec3 r = x[2] - 0.5 * (x[0] + x[1]);
    return Vec3(r - c.axis * c.axis.dot(r));
  };
  const Vec3 ra = arm(a), rb = arm(b);
  c.value = std::remainder(std::atan2(c.axis.dot(rb.cross(ra)), rb.dot(ra)) - link.zero, 2.0 * std::numbers::pi);
  const bool at_b = link.b.on_nodes() && !link.a.on_nodes();
  const Vec3& r = at_b ? rb : ra;
  c.lever = r.norm();
  c.n = c.lever > 0.0 ? Vec3(c.axis.cross(r) / c.lever) : c.axis;
  c.point = at_b ? b[2] : a[2];
  return c;
}

void Links::set_drive(std::size_t i, double position, double velocity) {
  auto& joint = links_[i].given.joint;
  if (!joint || !(joint->drive.stiffness > 0.0 || joint->drive.damping > 0.0))
    throw InputError(fmt::format("attachment '{}' has no drive", links_[i].given.name));
  if (!std::isfinite(position) || !std::isfinite(velocity)) throw InputError("the target of a drive is not finite");
  joint->drive.keys.clear();
  joint->drive.target = position, joint->drive.target_velocity = velocity;
}

void Links::Link::follow(std::span<const WorldPart> parts, std::span<const double> q,
                         std::span<const std::size_t> first_q) {
  const auto coordinates = [&](int body) { return q.subspan(first_q[body], first_q[body + 1] - first_q[body]); };
  a.follow(parts[part_a], coordinates(body_a));
  if (part_b >= 0) b.follow(parts[part_b], coordinates(body_b));
}

void Links::find_ends(std::size_t i, std::span<const WorldPart> parts, std::span<const double> q,
                      std::span<const std::size_t> first_q, double time) {
  Link& link = links_[i];
  link.given.ends.clear();
  if (link.broken) return;
  link.follow(parts, q, first_q);
  for (const Held& held : link.held) {
    if (held.hold == Hold::Drive || held.hold == Hold::Lower || held.hold == Hold::Upper) continue;
    const Vec3 b = link.b.positions()[held.point];
    link.given.ends.emplace_back(link.a.positions()[held.point],
                                 link.given.motion ? link.given.motion(time, b, link.middle) : b);
  }
}

void Links::append(std::span<const WorldPart> parts, std::span<const double> q, std::span<const std::size_t> first_q,
                   int space, double time, double dt, ContactSet& set) {
  time_ = time, dt_ = dt;
  ties_.clear();
  coordinate_.assign(links_.size(), {});
  const std::size_t first = set.size();
  std::vector<Vec3> point_a, point_b;
  for (std::size_t l = 0; l < links_.size(); ++l) {
    Link& link = links_[l];
    if (link.broken) continue;
    link.follow(parts, q, first_q);
    const Coordinate c = coordinate_[l] = coordinate(link);
    const double h = parts[link.part_a].h;
    set.pairs.push_back({link.part_a, link.part_b < 0 ? space : link.part_b, h, h, 0.0, first + ties_.size(),
                         first + ties_.size() + link.held.size()});
    ++set.link_pairs;
    for (std::size_t k = 0; k < link.held.size(); ++k) {
      const Held& held = link.held[k];
      Vec3 xa = link.a.positions()[held.point], xb = link.b.positions()[held.point];
      Tie tie;
      tie.link = l, tie.held = k;
      if (link.given.motion) {
        const Vec3 at_rest = xb;
        xb = link.given.motion(time, at_rest, link.middle);
        tie.target = (link.given.motion(time + dt, at_rest, link.middle) - xb) / dt;
      }
      tie.error = xa - xb;
      if (held.hold == Hold::Along) {
        const double now = tie.error.norm();
        if (now > 0.0) tie.n = tie.error / now;
        tie.error = (now - held.length) * tie.n;
      } else if (held.hold == Hold::Drive || held.hold == Hold::Lower || held.hold == Hold::Upper) {
        tie.n = c.n, tie.lever = c.lever;
        xa = xb = c.point;
      } else {
        if (held.gap != Vec3::Zero()) {
          const double now = std::exp(-(time - link.start) / kClosing), next = now * std::exp(-dt / kClosing);
          tie.error -= now * held.gap;
          tie.target += (next - now) / dt * held.gap;
        }
        if (held.hold == Hold::Across) tie.n = c.axis, tie.error -= c.axis * c.axis.dot(tie.error);
        if (link.b.in_space() || held.hold == Hold::Across || (link.a.on_nodes() && !link.b.on_nodes()))
          xb = xa;
        else if (link.b.on_nodes() && !link.a.on_nodes())
          xa = xb;
        else
          xa = xb = 0.5 * (xa + xb);
      }
      point_a.push_back(xa), point_b.push_back(xb);
      ties_.push_back(tie);
    }
  }
  set.resize(first + ties_.size());
  std::size_t c = first;
  for (std::size_t p = set.first_link_pair(); p < set.pairs.size(); ++p)
    for (; c < set.pairs[p].end; ++c) {
      const Tie& tie = ties_[c - first];
      const Link& link = links_[tie.link];
      const std::size_t i = link.held[tie.held].point;
      Contact contact{};
      contact.point = point_a[c - first];
      contact.node = (contact.point / set.pairs[p].h).array().round().cast<int>();
      contact.source_a = link.a.source(i), contact.source_b = link.b.source(i);
      set.set(c, contact);
    }
  set.link_point_b = std::move(point_b);
}

void Links::drive(const Link& link, const Tie& tie, const Vec3& velocity, Bond& bond) const {
  const LinkJoint& j = *link.given.joint;
  const Hold hold = link.held[tie.held].hold;
  const double value = coordinate_[tie.link].value, lever = tie.lever, u = tie.n.dot(velocity) / lever;
  double force = 0.0, K = 0.0, D = 0.0;  // along the coordinate
  if (hold == Hold::Drive) {
    const JointDrive& d = j.drive;
    if (d.stiffness > 0.0 || d.damping > 0.0) {
      const auto [target, rate] = aim_of(d, time_, dt_);
      double miss = target - value;
      if (j.kind == JointKind::Revolute) miss = std::remainder(miss, 2.0 * std::numbers::pi);
      const double wanted = d.stiffness * miss + d.damping * (rate - u), size = std::abs(wanted);
      // As JointForces: the secant keeps to the limit where the joint is held.
      const double s = size > d.force_limit ? d.force_limit / size : 1.0;
      force += s * wanted, K += s * d.stiffness, D += s * d.damping;
    }
    force -= j.damping * u, D += j.damping;
    force -= dt_ * K * u;
  } else {
    const double sign = hold == Hold::Upper ? 1.0 : -1.0;
    const double beyond = sign * (value - (hold == Hold::Upper ? j.upper : j.lower));
    K = j.limit_stiffness > 0.0 ? j.limit_stiffness : rigid(link) * lever * lever;
    force = -sign * (K * beyond + dt_ * K * sign * u);
    bond.one_way = true;
    bond.waits = !(beyond + dt_ * sign * u > 0.0);
    bond.n = -sign * tie.n;
  }
  bond.force = force / lever * tie.n;
  bond.across = dt_ * (dt_ * K + D) / (lever * lever);
}

void Links::begin(const ContactSet& set, std::span<const Vec3> velocity_a, std::span<const Vec3> velocity_b,
                  Penalty& response) const {
  std::vector<Bond> bonds(ties_.size());
  const std::size_t first = set.first_link();
  for (std::size_t i = 0; i < ties_.size(); ++i) {
    const Tie& tie = ties_[i];
    const Link& link = links_[tie.link];
    const Held& held = link.held[tie.held];
    const double k = held.share * (link.given.stiffness > 0.0 ? link.given.stiffness : rigid(link));
    const double d = held.share * link.given.damping, s = dt_ * k + d;
    const Vec3 u = velocity_a[first + i] - velocity_b[first + i] - tie.target;
    Bond& bond = bonds[i];
    bond.n = tie.n;
    switch (held.hold) {
      case Hold::Point:
        bond.along = dt_ * s;
        bond.force = -k * tie.error - s * u;
        break;
      case Hold::Across:
        bond.along = dt_ * s, bond.across = -dt_ * s;
        bond.force = -k * tie.error - s * (u - tie.n * tie.n.dot(u));
        break;
      case Hold::Along:
        bond.across = dt_ * s;
        bond.force = -k * tie.error - s * tie.n.dot(u) * tie.n;
        bond.one_way = link.given.pulls_only;
        if (!bond.one_way) break;
        bond.n = -tie.n;
        bond.waits = !(tie.n.dot(tie.error + dt_ * u) > 0.0);  // slack, and slack at the end of the step as well
        break;
      default:
        drive(link, tie, u, bond);
    }
  }
  response.set_bonds(std::move(bonds));
}

void Links::finish(const ContactSet& set, std::span<const Vec3> force, double time, StepReport& report) {
  report.links.clear();
  for (std::size_t l = 0; l < links_.size(); ++l) {
    report.links.push_back({});
    report.links.back().broken = links_[l].broken;
    report.links.back().coordinate = coordinate_[l].value;
  }
  const std::size_t first = set.first_link();
  for (std::size_t i = 0; i < ties_.size(); ++i) {
    const Tie& tie = ties_[i];
    LinkReport& r = report.links[tie.link];
    const Hold hold = links_[tie.link].held[tie.held].hold;
    // What acts along a coordinate that turns is one of a couple: the points that are held give the other.
    r.force += force[first + i];
    if (hold == Hold::Drive || hold == Hold::Lower || hold == Hold::Upper) {
      r.effort += tie.lever * tie.n.dot(force[first + i]);
      continue;
    }
    r.error = std::max(r.error, tie.error.norm());
  }
  for (std::size_t l = 0; l < links_.size(); ++l) {
    const double load = report.links[l].force.norm();
    if (links_[l].broken || !(load > links_[l].given.break_force)) continue;
    links_[l].broken = report.links[l].broken = true;
    if (report.warnings.size() < 16)
      report.warnings.push_back({time, "link_broken",
                                 fmt::format("'{}' broke: it carried {:.4g} N, above {:.4g} N", links_[l].given.name,
                                             load, links_[l].given.break_force)});
  }
}

void Links::take(std::vector<double>& memory) {
  for (Link& l : links_) l.broken = false;
  if (memory.size() < 2 || (memory[0] != kLinksMark && memory[0] != kOlderMark)) return;
  const auto n = static_cast<std::size_t>(std::clamp(memory[1], 0.0, static_cast<double>(memory.size() - 2)));
  for (std::size_t i = 0; i < n; ++i)
    if (const double l = memory[2 + i]; l >= 0.0 && l < static_cast<double>(links_.size()))
      links_[static_cast<std::size_t>(l)].broken = true;
  memory.erase(memory.begin(), memory.begin() + static_cast<std::ptrdiff_t>(2 + n));
}

void Links::keep(std::vector<double>& memory) const {
  std::vector<double> head = {kLinksMark, 0.0};
  for (std::size_t l = 0; l < links_.size(); ++l)
    if (links_[l].broken) head.push_back(static_cast<double>(l));
  if (head.size() == 2) return;
  head[1] = static_cast<double>(head.size() - 2);
  memory.insert(memory.begin(), head.begin(), head.end());
}

}  // namespace brim
