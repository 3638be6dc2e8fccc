#include "brim/world/outer_actions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "brim/body/flow_places.h"
#include "brim/body/spinning_balls.h"
#include "brim/core/error.h"
#include "brim/math/small_symmetric.h"

namespace brim {

namespace {

double at_time(const std::vector<NumberKey>& keys, double time) {
  if (keys.empty()) return 1.0;
  if (time <= keys.front().time) return keys.front().value;
  if (time >= keys.back().time) return keys.back().value;
  const auto next =
      std::upper_bound(keys.begin(), keys.end(), time, [](double t, const NumberKey& k) { return t < k.time; });
  const NumberKey &a = *(next - 1), &b = *next;
  const double s = (time - a.time) / (b.time - a.time);
  return (1.0 - s) * a.value + s * b.value;
}

bool moves_rigidly(const Body& body) {
  std::vector<double> v(body.v_size());
  return body.rigid_motion(Vec3::UnitX(), Vec3::Zero(), v);
}

Vec3 pull_at(const AppliedForce::Attractor& a, const Vec3& x) {
  const Vec3 way = a.center - x;
  const double r = way.norm();
  if (!(r > 0.0) || r > a.range) return Vec3::Zero();
  return a.strength * std::pow(r / a.range, a.power) * (way / r);
}

}  // namespace

int OuterActions::add(const AppliedForce& given, std::span<const std::unique_ptr<Body>> bodies,
                      std::span<const WorldPart> parts, std::span<const double> q, std::span<const std::size_t> first_q,
                      double ramp_voxels) {
  const auto refuse = [&](const std::string& what) {
    return InputError(fmt::format("force '{}': {}", given.name, what));
  };
  for (const auto& e : entries_)
    if (e->given.name == given.name) throw refuse("there is another one of that name");
  const bool at_points = given.point || given.region;
  if (given.point && given.region) throw refuse("a point or a region says where it acts, not both");
  if (at_points && given.force == Vec3::Zero()) throw refuse("a point or a region needs a force");
  if (!(given.damping >= 0.0)) throw refuse("damping must be a number from 0");
  if (given.attractor && (!(given.attractor->range > 0.0) || !(given.attractor->power >= 0.0)))
    throw refuse("the range of an attractor must be above 0 and its power at least 0");
  for (std::size_t k = 1; k < given.scale.size(); ++k)
    if (!(given.scale[k].time > given.scale[k - 1].time)) throw refuse("times of keys must increase");
  Entry entry;
  entry.given = given;
  entry.id = next_id_;
  const bool whole = (!at_points && given.force != Vec3::Zero()) || given.torque != Vec3::Zero() ||
                     given.acceleration != Vec3::Zero() || given.attractor;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const Body& body = *bodies[b];
    const bool named = std::any_of(given.bodies.begin(), given.bodies.end(),
                                   [&](const std::string& w) { return name_matches(w, body.name()); });
    if (!(named || given.bodies.empty()) || body.immobile() || body.v_size() == 0) continue;
    if (whole && !moves_rigidly(body) && !(has_nodes(body) && given.torque == Vec3::Zero())) {
      if (!named) continue;
      throw refuse(
          fmt::format("'{}' ({}) cannot move as a whole; forces act at its points only", body.name(), body.kind()));
    }
    if (given.wind && at_points) throw refuse("wind and forces at points need entries of their own");
    const auto first = std::find_if(parts.begin(), parts.end(),
                                    [&](const WorldPart& p) { return p.body_index == static_cast<int>(b); });
    const std::size_t from = static_cast<std::size_t>(first - parts.begin());
    const auto mine = parts.subspan(from, static_cast<std::size_t>(body.part_count()));
    const auto qb = q.subspan(first_q[b], first_q[b + 1] - first_q[b]);
    if (mine.empty() && (at_points || given.wind))
      throw refuse(fmt::format("'{}' ({}) has no matter to act on", body.name(), body.kind()));
    Action action;
    action.body = static_cast<int>(b);
    action.first_part = from;
    try {
      if (at_points) choose_points(given, mine, qb, ramp_voxels, action);
      if (given.wind) action.wind.emplace(mine, qb, ramp_voxels);
    } catch (const InputError& e) {
      throw refuse(e.what());
    }
    if (action.wind && action.wind->empty()) {
      if (!named) continue;
      throw refuse(
          fmt::format("'{}' ({}) shows nothing that keeps its matter, for wind to blow on", body.name(), body.kind()));
    }
    entry.actions.push_back(std::move(action));
  }
  if (entry.actions.empty()) throw refuse("no body that can move is named");
  scale_gravity(entry, bodies.size());
  entries_.push_back(std::make_shared<Entry>(std::move(entry)));
  ++next_id_;
  return static_cast<int>(entries_.size()) - 1;
}

void OuterActions::scale_gravity(const Entry& entry, std::size_t bodies) {
  if (!entry.given.gravity_scale) return;
  gravity_scale_.resize(bodies, 1.0);
  for (const Action& a : entry.actions) gravity_scale_[static_cast<std::size_t>(a.body)] = *entry.given.gravity_scale;
}

void OuterActions::set_list(const List& list) {
  std::size_t bodies = gravity_scale_.size();
  for (const auto& e : list)
    for (const Action& a : e->actions) bodies = std::max(bodies, static_cast<std::size_t>(a.body) + 1);
  gravity_scale_.clear();
  entries_ = list;
  for (const auto& e : entries_) scale_gravity(*e, bodies);
}

void OuterActions::flag_pulled(std::span<std::uint8_t> flags) const {
  for (const auto& e : entries_)
    for (const Action& a : e->actions)
      if (e->given.attractor || a.wind) flags[static_cast<std::size_t>(a.body)] = 1;
}

void OuterActions::flag_acted_on(std::span<std::uint8_t> flags) const {
  for (const auto& e : entries_)
    for (const Action& a : e->actions)
      if (e->given.attractor || a.wind || e->given.force != Vec3::Zero() || e->given.torque != Vec3::Zero())
        flags[static_cast<std::size_t>(a.body)] = 1;
}

void OuterActions::choose_points(const AppliedForce& given, std::span<const WorldPart> parts, std::span<const double> q,
                                 double ramp_voxels, Action& action) {
  const Body& body = *parts[0].body;
  if (given.region && dynamic_cast<const FlowPlaces*>(&body) != nullptr) {
    action.flow = true;
    return;
  }
  const std::vector<Vec3> x = given.point ? std::vector<Vec3>{*given.point} : points_in(body, given.region);
  std::vector<std::vector<Vec3>> of_part(parts.size());
  for (const Vec3& p : x) of_part[MatterPoints::nearest_part(parts, p)].push_back(p);
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (!of_part[i].empty())
      action.spots.push_back({i, MatterPoints::of_part(parts[i], ramp_voxels * parts[i].h, q, std::move(of_part[i]))});
}

void OuterActions::add_in_flow(const AppliedForce& given, const Body& body, std::span<double> Q) {
  std::vector<Vec3> place(Q.size());
  dynamic_cast<const FlowPlaces&>(body).velocity_places(place);
  std::vector<double> inside(Q.size()), image(Q.size(), 0.0);
  for (std::size_t i = 0; i < Q.size(); ++i) inside[i] = given.region(place[i]) ? 1.0 : 0.0;
  body.filter(inside);  // walls and dry cells take none
  body.apply_mass(inside, image);
  Vec3 mass = Vec3::Zero();
  for (std::size_t i = 0; i < Q.size(); ++i) mass[static_cast<int>(i % 3)] += image[i];
  for (std::size_t i = 0; i < Q.size(); ++i)
    if (const auto a = static_cast<int>(i % 3); mass[a] > 0.0) Q[i] += given.force[a] * image[i] / mass[a];
}

void OuterActions::add_at_points(const Vec3& force, std::span<const WorldPart> parts, std::span<const double> q,
                                 Action& action, std::span<double> Q) {
  std::size_t n = 0;
  for (const Spot& spot : action.spots) n += spot.points.size();
  const Vec3 share = force / static_cast<double>(n);
  for (Spot& spot : action.spots) {
    const WorldPart& part = parts[spot.part];
    spot.points.follow(part, q);
    const auto x = spot.points.positions();
    std::vector<std::int32_t> source(x.size());
    for (std::size_t i = 0; i < source.size(); ++i) source[i] = spot.points.source(i);
    std::unique_ptr<Map> map;
    part.body->make_map(part.index, x, source, map);
    map->apply_transpose(std::vector<Vec3>(x.size(), share), Q);
  }
}

void OuterActions::find_changing(double time, double dt, std::vector<int>& out) const {
  for (const auto& e : entries_) {
    const AppliedForce& given = e->given;
    const double now = at_time(given.scale, time);
    const bool blows = given.wind && given.wind->field;
    if (!blows && now == at_time(given.scale, time - dt) && now == at_time(given.scale, time + dt)) continue;
    for (const Action& a : e->actions) out.push_back(a.body);
  }
}

struct OuterActions::Target {
  const Body& body;
  std::span<const WorldPart> parts;
  std::span<const double> q, v;
  std::span<double> impulse;

  /// impulse += factor Q
  void add(double factor, std::span<const double> Q) const {
    for (std::size_t i = 0; i < impulse.size(); ++i) impulse[i] += factor * Q[i];
  }
  /// impulse += factor M motion
  void add_motion(double factor, std::span<const double> motion) const {
    std::vector<double> image(impulse.size(), 0.0);
    body.apply_mass(motion, image);
    add(factor, image);
  }
};

void OuterActions::add_damping(double damping, double dt, const Target& target) {
  if (damping > 0.0) target.add_motion(-(1.0 - std::exp(-damping * dt)), target.v);
}

void OuterActions::add_at_places(const AppliedForce& given, double factor, Action& action, const Target& target) {
  std::vector<double> Q(target.v.size(), 0.0);
  if (action.flow)
    add_in_flow(given, target.body, Q);
  else
    add_at_points(given.force, target.parts, target.q, action, Q);
  target.add(factor, Q);
}

void OuterActions::add_wind(const AirStep& step, WindOnBody& wind, const Target& target,
                            std::vector<Mat3>& resistance) {
  std::vector<double> Q(target.v.size(), 0.0);
  if (yields_implicitly(target.body)) resistance.resize(target.v.size() / 3, Mat3::Zero());
  wind.add_force(step, target.parts, target.q, target.v, Q, resistance);
  target.add(step.dt, Q);
}

void OuterActions::add_attraction(const AppliedForce::Attractor& attractor, double factor, const Target& target) {
  std::vector<double> motion(target.v.size(), 0.0);
  const std::size_t per_node = velocities_per_node(target.body);
  for (std::size_t i = 0; per_node * i < motion.size(); ++i)
    Eigen::Map<Vec3>(motion.data() + per_node * i) =
        pull_at(attractor, Eigen::Map<const Vec3>(target.q.data() + 3 * i));
  target.add_motion(factor, motion);
}

void OuterActions::add_as_whole(const AppliedForce& given, bool at_points, double factor, const Target& target) {
  const Body& body = target.body;
  const double m = body.mass();
  Vec3 uniform = given.acceleration;
  if (!at_points) uniform += given.force / m;
  const bool by_middle = given.attractor && !has_nodes(body);
  if (uniform == Vec3::Zero() && given.torque == Vec3::Zero() && !by_middle) return;
  std::vector<double> motion(target.v.size(), 0.0);
  // Centre of mass: p × F of a uniform field is m c × a.
  std::array<Vec3, 3> moment = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  for (int a = 0; a < 3; ++a) {
    if (!body.rigid_motion(Vec3::Unit(a), Vec3::Zero(), motion)) break;
    moment[a] = body.angular_momentum(motion);
  }
  const Vec3 center(moment[1].z() / m, moment[2].x() / m, moment[0].y() / m);
  if (by_middle) uniform += pull_at(*given.attractor, center);
  if (uniform != Vec3::Zero()) {
    if (!body.rigid_motion(uniform, Vec3::Zero(), motion))
      for (std::size_t i = 0; i < motion.size(); ++i) motion[i] = uniform[static_cast<int>(i % 3)];
    target.add_motion(factor, motion);
  }
  if (given.torque == Vec3::Zero()) return;
  // I α = T with I from the momenta of the three rotations about the centre.
  Mat3 inertia;
  for (int a = 0; a < 3; ++a) {
    const Vec3 w = Vec3::Unit(a);
    body.rigid_motion(-w.cross(center), w, motion);
    inertia.col(a) = body.angular_momentum(motion) - center.cross(body.linear_momentum(motion));
  }
  const Vec3 alpha = solve_symmetric(inertia, given.torque);
  body.rigid_motion(-alpha.cross(center), alpha, motion);
  target.add_motion(factor, motion);
}

std::span<const double> OuterActions::impulse(std::span<const std::unique_ptr<Body>> bodies,
                                              std::span<const WorldPart> parts, std::span<const double> q,
                                              std::span<const std::size_t> first_q, std::span<const double> v,
                                              std::span<const std::size_t> first_v, double time, double dt,
                                              std::span<const double> base) {
  gravity_scale_.resize(gravity_scale_.empty() ? 0 : bodies.size(), 1.0);
  impulse_.assign(base.begin(), base.end());
  impulse_.resize(first_v.back(), 0.0);
  resistance_.clear();
  for (const auto& e : entries_) {
    const AppliedForce& given = e->given;
    const double scale = at_time(given.scale, time);
    for (Action& action : e->actions) {
      const auto b = static_cast<std::size_t>(action.body);
      const Body& body = *bodies[b];
      const std::size_t n = first_v[b + 1] - first_v[b];
      if (n == 0) continue;  // removed
      const Target target{body, parts.subspan(action.first_part, static_cast<std::size_t>(body.part_count())),
                          q.subspan(first_q[b], first_q[b + 1] - first_q[b]), v.subspan(first_v[b], n),
                          std::span(impulse_).subspan(first_v[b], n)};
      add_damping(given.damping, dt, target);
      if (action.at_points()) add_at_places(given, scale * dt, action, target);
      if (action.wind) {
        resistance_.resize(bodies.size());
        add_wind({*given.wind, scale, time, dt}, *action.wind, target, resistance_[b]);
      }
      if (given.attractor && has_nodes(body)) add_attraction(*given.attractor, scale * dt, target);
      add_as_whole(given, action.at_points(), scale * dt, target);
    }
  }
  return impulse_;
}

}  // namespace brim
