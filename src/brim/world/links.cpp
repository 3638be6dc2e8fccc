#include "brim/world/links.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "brim/body/articulated/joint_forces.h"
#include "brim/core/error.h"

namespace brim {

namespace {

/// [s] A gap between two sides closes as exp(−t / kClosing).
constexpr double kClosing = 0.1;

/// Share of a gap that is left after a time.
double closing_left(double t) { return std::exp(-t / kClosing); }

}  // namespace

bool Links::needs_space() const {
  return std::any_of(links_.begin(), links_.end(), [](const auto& l) { return l->part_b < 0; });
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
    c.point = link.b.loose() ? b[4] : a[4];
    return c;
  }
  const auto arm = [&](std::span<const Vec3> x) {
    const Vec3 r = x[2] - 0.5 * (x[0] + x[1]);
    return Vec3(r - c.axis * c.axis.dot(r));
  };
  const Vec3 ra = arm(a), rb = arm(b);
  c.value = std::remainder(std::atan2(c.axis.dot(rb.cross(ra)), rb.dot(ra)) - link.zero, 2.0 * std::numbers::pi);
  const bool at_b = link.b.bound() > link.a.bound();
  const Vec3& r = at_b ? rb : ra;
  c.lever = r.norm();
  c.n = c.lever > 0.0 ? Vec3(c.axis.cross(r) / c.lever) : c.axis;
  c.point = at_b ? b[2] : a[2];
  return c;
}

void Links::set_drive(std::size_t i, double position, double velocity) {
  const auto& joint = links_[i]->given.joint;
  if (!joint || !(joint->drive.stiffness > 0.0 || joint->drive.damping > 0.0))
    throw InputError(fmt::format("attachment '{}' has no drive", links_[i]->given.name));
  for (const auto& [what, value] : {std::pair{"position", position}, std::pair{"velocity", velocity}})
    if (!std::isfinite(value))
      throw InputError(
          fmt::format("set_drive: {} {} of '{}' is not allowed; must be finite", what, value, links_[i]->given.name));
  links_[i]->aim = DriveAim{position, velocity};
}

std::pair<double, double> Links::target_of(const Link& link, double time) {
  return link.aim ? std::pair(link.aim->position, link.aim->velocity) : target_at(link.given.joint->drive, time);
}

void Links::set_list(const List& list) {
  links_.erase(links_.begin(), links_.begin() + static_cast<std::ptrdiff_t>(kept()));
  links_.insert(links_.begin(), list.begin(), list.end());
}

void Links::Link::follow(std::span<const WorldPart> parts, std::span<const double> q,
                         std::span<const std::size_t> first_q) {
  const auto coordinates = [&](int body) { return q.subspan(first_q[body], first_q[body + 1] - first_q[body]); };
  a.follow(parts[part_a], coordinates(body_a));
  if (part_b >= 0) b.follow(parts[part_b], coordinates(body_b));
}

void Links::find_ends(std::size_t i, std::span<const WorldPart> parts, std::span<const double> q,
                      std::span<const std::size_t> first_q, double time) {
  Link& link = *links_[i];
  link.given.ends.clear();
  if (link.broken) return;
  link.follow(parts, q, first_q);
  for (const Held& held : link.held) {
    if (along_coordinate(held.hold)) continue;
    const Vec3 b = link.b.positions()[held.point];
    link.given.ends.emplace_back(link.a.positions()[held.point],
                                 link.given.motion ? link.given.motion(time, b, link.middle) : b);
  }
}

std::pair<Vec3, Vec3> Links::stretch(const Link& link, const Held& held, const Coordinate& c, double time, Vec3& n,
                                     Vec3& error) {
  const Vec3 a = link.a.positions()[held.point], rest = link.b.positions()[held.point],
             b = link.given.motion ? link.given.motion(time, rest, link.middle) : rest;
  error = a - b;
  if (held.hold == Hold::Along) {
    const double now = error.norm();
    if (now > 0.0) n = error / now;
    error = (now - held.length) * n;
    return {a, b};
  }
  if (held.gap != Vec3::Zero()) error -= closing_left(time - link.start) * held.gap;
  if (held.hold == Hold::Across) n = c.axis, error -= n * n.dot(error);
  return {a, b};
}

void Links::append(std::span<const WorldPart> parts, const Motion& motion, int space, double time, double dt,
                   double longest, ContactSet& set) {
  time_ = time, dt_ = dt, closing_ = std::min(1.0, dt / longest);
  ties_.clear();
  coordinate_.assign(links_.size(), {});
  const std::size_t first = set.size();
  std::vector<Vec3> point_a, point_b;
  for (std::size_t l = 0; l < links_.size(); ++l) {
    Link& link = *links_[l];
    if (link.broken) continue;
    link.follow(parts, motion.q, motion.first_q);
    const Coordinate c = coordinate_[l] = coordinate(link);
    const double h = parts[link.part_a].h;
    set.pairs.push_back({link.part_a, link.part_b < 0 ? space : link.part_b, h, h, 0.0, first + ties_.size(),
                         first + ties_.size() + link.held.size()});
    ++set.link_pairs;
    for (std::size_t k = 0; k < link.held.size(); ++k) {
      const Held& held = link.held[k];
      Tie tie;
      tie.link = l, tie.held = k;
      const bool along = along_coordinate(held.hold);
      const auto [at_a, at_b] = along ? std::pair(c.point, c.point) : stretch(link, held, c, time, tie.n, tie.error);
      Vec3 xa = at_a, xb = at_b;
      if (along) {
        tie.n = c.n, tie.lever = c.lever;
      } else {
        if (link.given.motion)
          tie.target = (link.given.motion(time + dt, link.b.positions()[held.point], link.middle) - xb) / dt;
        if (held.gap != Vec3::Zero())
          tie.target += (closing_left(time + dt - link.start) - closing_left(time - link.start)) / dt * held.gap;
      }
      if (!along && held.hold != Hold::Along) {
        if (link.b.loose() || (link.b.bound() > link.a.bound() && held.hold != Hold::Across))
          xa = xb;
        else if (link.b.in_space() || held.hold == Hold::Across || link.a.bound() > link.b.bound())
          xb = xa;
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
      const Link& link = *links_[tie.link];
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
      // As in JointForces: of keyframes the mean rate over the sub-step.
      auto [target, rate] = target_of(link, time_ + dt_);
      if (!link.aim && !d.keys.empty()) rate = (target - target_of(link, time_).first) / dt_;
      double miss = target - value;
      if (j.kind == JointKind::Revolute) miss = std::remainder(miss, 2.0 * std::numbers::pi);
      const double wanted = d.stiffness * miss + d.damping * (rate - u), size = std::abs(wanted);
      // As in JointForces: the secant respects the limit when the joint is held.
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
    bond.one_way = bond.stops = true;
    bond.waits = !(beyond + dt_ * sign * u > 0.0);
    bond.n = -sign * tie.n;
  }
  bond.force = force / lever * tie.n;
  bond.across = dt_ * (dt_ * K + D) / (lever * lever);
}

std::vector<Bond> Links::bonds() const {
  std::vector<Bond> bonds(ties_.size());
  for (std::size_t i = 0; i < ties_.size(); ++i) {
    const Tie& tie = ties_[i];
    const Link& link = *links_[tie.link];
    const Held& held = link.held[tie.held];
    const double k = held.share * (link.given.stiffness > 0.0 ? link.given.stiffness : rigid(link));
    const double d = held.share * link.given.damping, s = dt_ * k + d;
    const Vec3 u = tie.velocity - tie.target;
    const Vec3 error = (link.given.stiffness > 0.0 ? 1.0 : closing_) * tie.error + tie.arc;
    Bond& bond = bonds[i];
    bond.n = tie.n;
    switch (held.hold) {
      case Hold::Point:
        bond.along = dt_ * s;
        bond.force = -k * error - s * u;
        break;
      case Hold::Across:
        bond.along = dt_ * s, bond.across = -dt_ * s;
        bond.force = -k * error - s * (u - tie.n * tie.n.dot(u));
        break;
      case Hold::Along:
        bond.across = dt_ * s;
        bond.force = -k * error - s * tie.n.dot(u) * tie.n;
        bond.one_way = link.given.pulls_only;
        if (!bond.one_way) break;
        if (tie.n.dot(error) < 0.0) bond.force -= k * (tie.error - error);  // slack, until it is drawn out
        bond.n = -tie.n;
        bond.waits = !(tie.n.dot(tie.error + dt_ * u) > 0.0);  // slack now, and at the end of the step too
        break;
      default:
        drive(link, tie, u - axis_velocity(i), bond);
    }
  }
  return bonds;
}

Vec3 Links::axis_velocity(std::size_t i) const {
  const Link& link = *links_[ties_[i].link];
  Vec3 velocity = Vec3::Zero();
  if (link.given.joint->kind != JointKind::Revolute || link.given.stiffness > 0.0) return velocity;
  for (std::size_t end = i - ties_[i].held; end < i - ties_[i].held + 2; ++end)
    velocity += 0.5 * (ties_[end].target - (closing_ * ties_[end].error + ties_[end].arc) / dt_);
  return velocity;
}

void Links::begin(std::span<const WorldPart> parts, const Motion& motion, const ContactSet& set,
                  std::span<const Vec3> velocity_a, std::span<const Vec3> velocity_b, Penalty& response) {
  const std::size_t first = set.first_link();
  for (std::size_t i = 0; i < ties_.size(); ++i) ties_[i].velocity = velocity_a[first + i] - velocity_b[first + i];
  start_arcs(parts, motion, set);
  response.set_bonds(bonds());
}

}  // namespace brim
