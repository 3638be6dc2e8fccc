#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <set>

#include "brim/body/loose_nodes.h"
#include "brim/body/material_points.h"
#include "brim/body/posed_shape.h"
#include "brim/body/spinning_balls.h"
#include "brim/core/error.h"
#include "brim/world/contact_parameters.h"
#include "brim/world/links.h"
#include "brim/world/wind.h"

/// Construction of links: which points of both sides they hold, and how.
namespace brim {

namespace {

/// Distance of the two ends, relative to the grid step, up to which they coincide.
constexpr double kSamePlace = 1e-3;

/// Gap between two sides, relative to the step, up to which they count as the same place: it closes.
constexpr double kSeam = 0.5;
/// The same for a joint, whose two sides are placed where their material is nearest to each other, and for loose nodes,
/// which lie beside the part that holds them.
constexpr double kJointSeam = 3.0;
/// Rounds in which each side moves to the other's point, to find a place with material on both sides.
constexpr int kTogether = 12;
/// [voxels] Error of a rigid link that shows.
constexpr double kApart = 1.0;
/// [voxels] Distance of points that a joint needs to hold a direction.
constexpr double kLeastSpread = 0.1;

/// The given part of a side, or the one whose box is nearest to x.
int choose_part(std::span<const WorldPart> parts, const std::vector<int>& mine, int wanted, const Vec3& x) {
  if (wanted >= static_cast<int>(mine.size()))
    throw InputError(
        fmt::format("part {} is not allowed; '{}' has {}", wanted, parts[mine[0]].body->name(), mine.size()));
  if (wanted >= 0) return mine[wanted];
  return mine[MatterPoints::nearest_part(parts.subspan(static_cast<std::size_t>(mine[0]), mine.size()), x)];
}

/// [kg] mass behind a side's points: for loose nodes their own.
double mass_behind(const WorldPart& part, const MatterPoints& points) {
  const double mass = part.body->mass();
  if (!points.loose()) return mass;
  const std::size_t nodes = part.body->v_size() / velocities_per_node(*part.body);
  return mass * std::min(1.0, static_cast<double>(points.size()) / static_cast<double>(nodes));
}

/// Some well-spread points: each is the farthest from those before it.
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

/// Shortest distance from a hinge's axis used to read its angle, relative to the held length of the axis.
constexpr double kArm = 0.02;

/// Distance of the third held point from the line through the others, relative to their distance: the smaller value of
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

/// [voxels] Smallest distance of the points of a joint from its position when a side has loose nodes: their spacing is
/// about two, and each point needs a node of its own.
constexpr double kLooseSpan = 2.0;

/// Distance of the points that a joint holds, relative to the largest extent of solids: as far apart as their mass, so
/// that a rigid joint is as rigid against turning as against moving. The smaller solid counts up to twice.
constexpr double kSpanOfSolids = 0.5, kBeyondSmaller = 2.0;
/// The same, relative to the smallest extent of what holds only the matter that it has.
constexpr double kSpanOfMatter = 0.25;

/// @param b  none: space
double span_of(const LinkJoint& joint, const WorldPart& a, const WorldPart* b) {
  if (joint.span > 0.0) return joint.span;
  double smaller = std::numeric_limits<double>::infinity(), larger = 0.0, span = smaller;
  for (const WorldPart* part : {&a, b}) {
    if (part == nullptr) continue;
    const Vec3 extent = part->body->bounds(part->index).extent();
    if (const double most = extent.maxCoeff(); std::isfinite(most) && most > 0.0)
      smaller = std::min(smaller, most), larger = std::max(larger, most);
    if (const double least = extent.minCoeff(); !MatterPoints::takes_any(*part) && std::isfinite(least) && least > 0.0)
      span = std::min(span, kSpanOfMatter * least);
  }
  if (larger > 0.0) span = std::min(span, kSpanOfSolids * std::min(larger, kBeyondSmaller * smaller));
  for (const WorldPart* part : {&a, b})
    if (part != nullptr && dynamic_cast<const LooseNodes*>(part->body) != nullptr)
      span = std::max(span, kLooseSpan * part->h);
  return std::isfinite(span) ? span : 4.0 * a.h;
}

double worst_gap(const MatterPoints& a, const MatterPoints& b) {
  double worst = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, (a.positions()[i] - b.positions()[i]).norm());
  return worst;
}

/// The first point of each cell of a grid: what is shown more finely than it moves is not held by every vertex shown.
std::vector<Vec3> one_per_cell(const std::vector<Vec3>& x, double cell) {
  std::set<std::array<std::int64_t, 3>> taken;
  std::vector<Vec3> out;
  for (const Vec3& p : x) {
    const Vec3 c = (p / cell).array().floor();
    if (taken.insert({std::llround(c.x()), std::llround(c.y()), std::llround(c.z())}).second) out.push_back(p);
  }
  return out;
}

/// Name of the link in messages.
std::string told(const Attachment& given) {
  return fmt::format("{} '{}'", given.joint ? "joint" : "attachment", given.name);
}

/// Refuses values, and combinations of them, that make no link. @param a, b  parts of the sides
void check_given(const Attachment& given, const std::vector<int>& a, const std::vector<int>& b) {
  for (const auto& [what, value] : {std::pair{"stiffness", given.stiffness}, std::pair{"damping", given.damping},
                                    std::pair{"length", given.length.value_or(0.0)}})
    if (!(value >= 0.0) || !std::isfinite(value))
      throw InputError(fmt::format("{} {} is not allowed; must be a number from 0", what, value));
  if (!(given.break_force > 0.0)) throw InputError("break_force must be above 0");
  if (given.point.has_value() + static_cast<bool>(given.region) + given.joint.has_value() != 1)
    throw InputError("exactly one of a point, a region and a joint says what is held");
  if (given.joint && (given.to_point || given.length || given.pulls_only))
    throw InputError("to_point, length and pulls_only are not for joints");
  if (given.region && given.to_point) throw InputError("a region is held where it is; to_point is for a point");
  if (given.motion && !b.empty()) throw InputError("only what is held to space can be moved by keyframes");
  if (a.empty()) throw InputError("the body has no part to hold");
}

/// Refuses sides whose points cannot hold a joint together.
void check_joint_sides(const Attachment& given, const MatterPoints& a, const MatterPoints& b, double h) {
  if (a.loose() && b.loose())
    throw InputError(
        fmt::format("'{}' and '{}' are both of particles that move past each other and have no place in "
                    "common; hold them by attachments, which are rods between two particles",
                    given.body, given.to));
  if (const double apart = worst_gap(a, b); apart > kJointSeam * h)
    throw InputError(fmt::format(
        "the two sides have no matter within {:.3g} m ({:.0f} voxels) of each other at the joint (theirs is "
        "{:.3g} m apart); give a smaller span or another place",
        kJointSeam * h, kJointSeam, apart));
  const JointKind kind = given.joint->kind;
  const bool has_axis = kind == JointKind::Revolute || kind == JointKind::Prismatic;
  const auto apart_by = [&](std::span<const Vec3> x, std::size_t i) { return (x[i] - x[0]).norm(); };
  const std::size_t ends = kind == JointKind::Fixed ? a.size() : has_axis ? 2 : 0;
  double spread = ends > 0 ? 0.0 : std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < ends; ++i)
    spread = std::max(spread, std::min(apart_by(a.positions(), i), apart_by(b.positions(), i)));
  if (spread < kLeastSpread * h)
    throw InputError(fmt::format("{} too little matter about the {}; give a larger span",
                                 given.to.empty() ? fmt::format("'{}' has", given.body)
                                                  : fmt::format("'{}' and '{}' have", given.body, given.to),
                                 kind == JointKind::Fixed ? "joint" : "axis"));
}

}  // namespace

int Links::add(const Attachment& given, std::span<const WorldPart> parts, const Side& a, const Side& b,
               double ramp_voxels, double time) {
  const auto end = links_.begin() + static_cast<std::ptrdiff_t>(kept());
  if (std::any_of(links_.begin(), end, [&](const auto& l) { return l->given.name == given.name; }))
    throw InputError(fmt::format("{}: there is another one of that name", told(given)));
  auto link = std::make_shared<Link>(make(given, parts, a, b, ramp_voxels, time));
  link->id = next_id_++;
  links_.insert(end, std::move(link));
  return static_cast<int>(kept()) - 1;
}

void Links::grab(const Attachment& given, std::span<const WorldPart> parts, const Side& a, double ramp_voxels,
                 double time) {
  auto link = std::make_shared<Link>(make(given, parts, a, {}, ramp_voxels, time));
  release();
  links_.push_back(std::move(link));
  grabs_ = true;
}

void Links::release() {
  if (grabs_) links_.pop_back();
  grabs_ = false;
}

/// Binds the two sides of a link to matter at the same points.
class Links::SideBinder {
 public:
  /// @param x  [m] points of side a
  SideBinder(Link& link, std::span<const WorldPart> parts, const Side& a, const Side& b, double ramp_voxels,
             std::vector<Vec3> x)
      : link_(link), parts_(parts), side_a_(a), side_b_(b), ramp_voxels_(ramp_voxels), x_(std::move(x)) {}

  void bind() {
    y_ = x_;
    if (to_point()) y_ = {*link_.given.to_point};
    if (side_b_.parts.empty()) {
      bind_to_space();
      return;
    }
    if (!link_.given.joint) link_.part_b = choose_part(parts_, side_b_.parts, link_.given.to_part, y_[0]);
    link_.body_b = parts_[link_.part_b].body_index;
    // The side that can carry any point follows the other.
    if (!to_point() && MatterPoints::takes_any(parts_[link_.part_a]) &&
        !MatterPoints::takes_any(parts_[link_.part_b])) {
      bind_b();
      x_ = points_of(link_.b);
      bind_a();
      return;
    }
    bind_a();
    if (!to_point()) y_ = points_of(link_.a);
    bind_b();
    if (link_.given.joint) approach();
  }

 private:
  void bind_to_space() {
    bind_a();
    if (!to_point()) y_ = points_of(link_.a);
    link_.b = MatterPoints::of_space(y_);
  }

  /// If neither side can carry any point, each follows the other in turn; the round with the smallest distance counts.
  void approach() {
    std::vector<Vec3> nearest = x_;
    double least = worst_gap(link_.a, link_.b), now = least;
    for (int i = 1; i < kTogether && least > kSamePlace * parts_[link_.part_a].h; ++i) {
      follow_each_other(points_of(link_.b));
      now = worst_gap(link_.a, link_.b);
      if (now < least) least = now, nearest = x_;
    }
    if (now > least) follow_each_other(std::move(nearest));
  }

  void follow_each_other(std::vector<Vec3> x) {
    x_ = std::move(x);
    bind_a();
    y_ = points_of(link_.a);
    bind_b();
  }

  void bind_a() { link_.a = bound(parts_[link_.part_a], side_a_, x_); }
  void bind_b() { link_.b = bound(parts_[link_.part_b], side_b_, y_); }
  MatterPoints bound(const WorldPart& part, const Side& side, const std::vector<Vec3>& x) const {
    return MatterPoints::of_part(part, ramp_voxels_ * part.h, side.q, x);
  }
  static std::vector<Vec3> points_of(const MatterPoints& m) {
    return std::vector<Vec3>(m.positions().begin(), m.positions().end());
  }
  bool to_point() const { return link_.given.to_point.has_value(); }

  Link& link_;
  std::span<const WorldPart> parts_;
  const Side &side_a_, &side_b_;
  double ramp_voxels_;
  std::vector<Vec3> x_, y_;  ///< [m] points to which a and b are bound
};

Links::Link Links::make(const Attachment& given, std::span<const WorldPart> parts, const Side& a, const Side& b,
                        double ramp_voxels, double time) {
  try {
    check_given(given, a.parts, b.parts);
    Link link;
    link.given = given;
    link.start = time;
    SideBinder(link, parts, a, b, ramp_voxels, place(link, parts, a, b)).bind();
    for (const Vec3& p : link.b.positions()) link.middle += p / static_cast<double>(link.b.size());
    choose_held(link, parts[link.part_a].h);
    find_mass(link, parts);
    link.apart = kApart * parts[link.part_a].h;
    return link;
  } catch (const InputError& e) {
    throw InputError(fmt::format("{}: {}", told(given), e.what()));
  }
}

std::vector<Vec3> Links::place(Link& link, std::span<const WorldPart> parts, const Side& a, const Side& b) {
  const Attachment& given = link.given;
  std::vector<Vec3> x;
  if (given.region) {
    const Body& body = *parts[a.parts[0]].body;
    x = points_in(body, given.region);
    link.part_a = choose_part(parts, a.parts, given.part, x[0]);
    if (has_distance(parts[link.part_a]))
      x = spread_of(x, kMostOfSolid);
    else if (!shows_nodes(body))
      x = one_per_cell(x, parts[link.part_a].h);
  } else {
    const Vec3 at = given.joint ? given.joint->position : *given.point;
    link.part_a = choose_part(parts, a.parts, given.part, at);
    x = {at};
  }
  const WorldPart& pa = parts[link.part_a];
  link.body_a = pa.body_index;
  if (!given.joint) return x;
  if (!b.parts.empty()) link.part_b = choose_part(parts, b.parts, given.to_part, x[0]);
  return joint_points(*given.joint, span_of(*given.joint, pa, link.part_b < 0 ? nullptr : &parts[link.part_b]));
}

void Links::find_mass(Link& link, std::span<const WorldPart> parts) {
  const double mass_a = mass_behind(parts[link.part_a], link.a);
  const double mass_b =
      link.part_b < 0 ? std::numeric_limits<double>::infinity() : mass_behind(parts[link.part_b], link.b);
  const double least = std::min(mass_a, mass_b), most = std::max(mass_a, mass_b);
  link.mass = std::isinf(most) ? least : std::min(most, kUnequal * least);
  if (!std::isfinite(least)) throw InputError("neither side can move");
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
  if (!link.given.joint) {
    hold_attachment(link, h);
    return;
  }
  check_joint_sides(link.given, link.a, link.b, h);
  hold_joint(link, h);
  add_coordinate(link);
}

void Links::hold_attachment(Link& link, double h) {
  const double same_place = kSamePlace * h;
  const std::size_t n = link.a.size();
  // Two nodes never coincide: a line between them leaves no torque.
  const double seam = link.a.loose() && link.b.loose() ? same_place : kSeam * h;
  const double reach = link.a.loose() || link.b.loose() ? kJointSeam * h : seam;
  const bool line = link.given.to_point || link.given.length || link.given.pulls_only;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 gap = link.a.positions()[i] - link.b.positions()[i];
    const double apart = gap.norm(), length = link.given.length.value_or(apart);
    // A line needs two ends; coincident ends are held as a point.
    const bool along = line ? link.given.pulls_only || std::max(length, apart) > same_place : apart > seam;
    if (!line && n > 1 && apart > reach) continue;  // of a region: the other side has no material there
    Held& held = link.hold(i, along ? Hold::Along : Hold::Point, 1.0);
    held.length = length;
    if (!along) held.gap = gap;
  }
  if (link.held.empty()) throw InputError("the two sides have no matter in common in the region");
  for (Held& held : link.held) held.share = 1.0 / static_cast<double>(link.held.size());
}

void Links::hold_joint(Link& link, double h) {
  const JointKind kind = link.given.joint->kind;
  const bool slides = kind == JointKind::Prismatic, turns = kind == JointKind::Revolute;
  const std::size_t count = turns ? 2 : slides ? 4 : link.a.size();
  for (std::size_t i = 0; i < count; ++i) {
    Held& held = link.hold(i, slides ? Hold::Across : Hold::Point, 1.0 / static_cast<double>(count));
    const Vec3 gap = link.a.positions()[i] - link.b.positions()[i];
    if (gap.norm() > kSamePlace * h) held.gap = gap;
  }
}

void Links::add_coordinate(Link& link) {
  link.zero = coordinate(link).value;
  const LinkJoint& j = *link.given.joint;
  const bool slides = j.kind == JointKind::Prismatic, turns = j.kind == JointKind::Revolute;
  const bool acts = j.drive.stiffness > 0.0 || j.drive.damping > 0.0 || j.damping > 0.0;
  const bool limited = std::isfinite(j.lower) || std::isfinite(j.upper);
  if ((acts || limited) && !turns && !slides)
    throw InputError("only joints that turn or slide about an axis have limits, damping and drives");
  if ((acts || limited) && turns && least_arm(link.a.positions(), link.b.positions()) < kArm)
    throw InputError(
        "a drive, damping or limit of a revolute joint needs matter beside its axis on both sides, and one has none at "
        "the place that is held (a rod about its own axis has none at all); turn the axis, or hold it by bodies that "
        "are wider there");
  const std::size_t last = link.a.size() - 1;
  if (acts) link.hold(last, Hold::Drive, 1.0);
  if (std::isfinite(j.lower)) link.hold(last, Hold::Lower, 1.0);
  if (std::isfinite(j.upper)) link.hold(last, Hold::Upper, 1.0);
}

Links::Held& Links::Link::hold(std::size_t point, Hold how, double share) {
  return held.emplace_back(Held{point, how, share, 0.0, Vec3::Zero()});
}

}  // namespace brim
