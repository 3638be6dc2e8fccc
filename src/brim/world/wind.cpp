#include "brim/world/wind.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "brim/body/changing_surface.h"
#include "brim/body/material_points.h"
#include "brim/body/posed_display.h"
#include "brim/body/solid_of.h"
#include "brim/body/spinning_balls.h"
#include "brim/core/error.h"

namespace brim {

namespace {

/// The force of air on one side of a triangle. @param facing  A n, in the direction of the air's motion
/// @param slope  a bound of the derivative of the force with respect to the air's velocity, [kg/s]
Vec3 force_on_face(const AppliedForce::Wind& wind, const Vec3& air, const Vec3& facing, Mat3& slope) {
  slope.setZero();
  const double speed = air.norm(), area = facing.norm();
  if (!(speed > 0.0) || !(area > 0.0)) return Vec3::Zero();
  const Vec3 c = air / speed, n = facing / area;
  const double cosine = c.dot(n);
  slope = wind.density * area * speed *
          (wind.lift * n * n.transpose() + std::abs(wind.drag - wind.lift) * cosine * cosine * c * c.transpose());
  return 0.5 * wind.density * area * speed * speed * cosine * (wind.drag * cosine * c + wind.lift * (n - cosine * c));
}

/// Drag ½ ρ D A |c| c of a body of that frontal area. @param slope  of it, [kg/s]
/// @param mass  [kg] limits the force so that the body does not outrun the air; 0: no limit
Vec3 drag(const AirStep& step, const Vec3& air, double area, double mass, double& slope) {
  slope = step.wind.density * step.wind.drag * area * air.norm();
  return 0.5 * slope / (mass > 0.0 ? 1.0 + step.dt * slope / mass : 1.0) * air;
}

/// A n of a triangle, [m²].
Vec3 facing_of(std::span<const Vec3f> vertex, const Triangle& t) {
  const Vec3 a = vertex[t[0]].cast<double>(), b = vertex[t[1]].cast<double>(), c = vertex[t[2]].cast<double>();
  return 0.5 * (b - a).cross(c - a);
}

Vec3 middle_of(std::span<const Vec3f> vertex, const Triangle& t) {
  return ((vertex[t[0]] + vertex[t[1]] + vertex[t[2]]) / 3.0f).cast<double>();
}

/// Adds the force of air on triangles through the map of their part. @param x, facing  centres [m] and A n [m²] of each
/// @param source  of each centre, for make_map  @param resistance  of the body's nodes, or empty
void blow(const AirStep& step, const WorldPart& part, std::span<const Vec3> x, std::span<const Vec3> facing,
          std::span<const std::int32_t> source, std::span<const double> v, std::span<double> Q,
          std::span<Mat3> resistance) {
  const AppliedForce::Wind& wind = step.wind;
  std::unique_ptr<Map> map;
  part.body->make_map(part.index, x, source, map);
  std::vector<Vec3> u(x.size());
  map->apply(v, u);
  const std::vector<Vec3> flow = step.velocity_at(x);
  std::vector<Mat3> slopes(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vec3 air = step.scale * flow[i] - u[i];
    // Air pushes faces turned towards it: both sides of a sheet, the windward side of a closed surface.
    const double into = facing[i].dot(air);
    Vec3 windward = into < 0.0 ? Vec3(-facing[i]) : facing[i];
    if (!part.body->display().two_sided && !(into < 0.0)) windward.setZero();
    u[i] = force_on_face(wind, air, windward, slopes[i]);
    // At most the force that brings light matter to the air's speed.
    const double mass = part.info.areal_mass * windward.norm();
    const double steepest = wind.density * windward.norm() * std::max(wind.drag, wind.lift) * air.norm();
    if (resistance.empty() && mass > 0.0) u[i] /= 1.0 + step.dt * steepest / mass;
  }
  map->apply_transpose(u, Q);
  if (resistance.empty()) return;
  // Each node resists with its share of each triangle.
  std::vector<double> column(v.size());
  for (int k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < x.size(); ++i) u[i] = slopes[i].col(k);
    std::fill(column.begin(), column.end(), 0.0);
    map->apply_transpose(u, column);
    for (std::size_t i = 0; i < resistance.size(); ++i)
      resistance[i].col(k) += Eigen::Map<const Vec3>(column.data() + 3 * i);
  }
}

/// The part of each display vertex if each part has vertices of its own; else all 0.
std::vector<std::size_t> parts_of_vertices(const Body& body) {
  std::vector<std::size_t> part(body.display().vertices, 0);
  if (body.part_count() == 1) return part;
  const PosedDisplay* posed = posed_display(body);
  if (posed == nullptr || posed->piece_count() != static_cast<std::size_t>(body.part_count()))
    throw InputError(fmt::format("'{}' ({}) has {} parts and does not say which of them shows what", body.name(),
                                 body.kind(), body.part_count()));
  std::size_t vertex = 0;
  for (std::size_t i = 0; i < posed->piece_count(); ++i)
    for (std::size_t k = 0; k < posed->piece(i).surface().vertices.size() && vertex < part.size(); ++k)
      part[vertex++] = i;
  return part;
}

}  // namespace

bool has_nodes(const Body& body) {
  const bool solid = body.part_count() > 0 && solid_of(body, 0) != nullptr;
  const std::size_t nodes = body.q_size() / 3;
  return !solid && dynamic_cast<const MaterialPoints*>(&body) == nullptr && body.q_size() == 3 * nodes &&
         body.v_size() == velocities_per_node(body) * nodes;
}

bool shows_nodes(const Body& body) { return has_nodes(body) && 3 * body.display().vertices == body.q_size(); }

bool yields_implicitly(const Body& body) {
  const std::vector<int> sizes = body.block_sizes();
  return has_nodes(body) && body.part_count() > 0 && !body.part(0).conforming && 3 * sizes.size() == body.v_size() &&
         std::ranges::all_of(sizes, [](int size) { return size == 3; });
}

std::vector<double> node_masses(const Body& body) {
  const std::size_t per_node = velocities_per_node(body);
  std::vector<double> along(body.v_size(), 0.0), image(body.v_size(), 0.0), mass(body.v_size() / per_node);
  for (std::size_t i = 0; i < along.size(); i += per_node) along[i] = 1.0;
  body.apply_mass(along, image);
  for (std::size_t i = 0; i < mass.size(); ++i) mass[i] = image[per_node * i];
  return mass;
}

std::vector<Vec3> AirStep::velocity_at(std::span<const Vec3> x) const {
  std::vector<Vec3> flow(x.size(), wind.velocity);
  if (wind.field) wind.field(time, x, flow);
  return flow;
}

WindOnBody::WindOnBody(std::span<const WorldPart> parts, std::span<const double> q, double ramp_voxels) {
  const Body& body = *parts[0].body;
  const Display& display = body.display();
  if (display.kind != Display::Kind::Triangles) {
    if (shows_nodes(body) && display.radius > 0.0) nodes_ = node_masses(body), per_node_ = velocities_per_node(body);
    return;
  }
  changing_ = changing_surface(body) != nullptr;
  if (display.triangles.empty()) return;
  std::vector<Vec3f> shown(display.vertices);
  body.display_positions(shown);
  const std::vector<std::size_t> part = parts_of_vertices(body);
  std::vector<std::vector<Vec3>> middles(parts.size());
  std::vector<std::vector<std::size_t>> triangles(parts.size());
  for (std::size_t t = 0; t < display.triangles.size(); ++t) {
    const Triangle& face = display.triangles[t];
    const std::size_t p = part[static_cast<std::size_t>(face[0])];
    middles[p].push_back(middle_of(shown, face));
    triangles[p].push_back(t);
  }
  for (std::size_t p = 0; p < parts.size(); ++p)
    if (!triangles[p].empty())
      faces_.push_back({p, MatterPoints::of_part(parts[p], ramp_voxels * parts[p].h, q, std::move(middles[p])),
                        std::move(triangles[p])});
}

void WindOnBody::add_force(const AirStep& step, std::span<const WorldPart> parts, std::span<const double> q,
                           std::span<const double> v, std::span<double> Q, std::span<Mat3> resistance) {
  for (Faces& faces : faces_) add_on_faces(step, faces, parts[faces.part], q, v, Q, resistance);
  if (changing_) add_on_changing(step, parts[0], v, Q);
  if (!nodes_.empty()) add_on_nodes(step, parts[0].body->display(), q, v, Q, resistance);
}

void WindOnBody::add_on_faces(const AirStep& step, Faces& faces, const WorldPart& part, std::span<const double> q,
                              std::span<const double> v, std::span<double> Q, std::span<Mat3> resistance) {
  const Body& body = *part.body;
  faces.middles.follow(part, q);
  const auto x = faces.middles.positions();
  std::vector<std::int32_t> source(x.size());
  for (std::size_t i = 0; i < source.size(); ++i) source[i] = faces.middles.source(i);
  const Display& display = body.display();
  std::vector<Vec3f> shown(display.vertices);
  body.display_positions(shown);
  std::vector<Vec3> facing(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) facing[i] = facing_of(shown, display.triangles[faces.triangle[i]]);
  blow(step, part, x, facing, source, v, Q, resistance);
}

void WindOnBody::add_on_changing(const AirStep& step, const WorldPart& part, std::span<const double> v,
                                 std::span<double> Q) {
  const ChangingSurface& surface = *changing_surface(*part.body);
  std::vector<Vec3f> shown;
  std::vector<Triangle> triangles;
  surface.display_surface(shown, triangles);
  std::vector<Vec3> x, facing;
  for (const Triangle& t : triangles)
    if (const Vec3 middle = middle_of(shown, t); surface.meets_air(middle))
      x.push_back(middle), facing.push_back(facing_of(shown, t));
  blow(step, part, x, facing, std::vector<std::int32_t>(x.size(), 0), v, Q, {});
}

void WindOnBody::add_on_nodes(const AirStep& step, const Display& display, std::span<const double> q,
                              std::span<const double> v, std::span<double> Q, std::span<Mat3> resistance) const {
  const auto at = [](std::span<const double> x, std::size_t i) { return Eigen::Map<const Vec3>(x.data() + 3 * i); };
  const auto velocity = [&](std::size_t i) { return Eigen::Map<const Vec3>(v.data() + per_node_ * i); };
  const auto add = [&](std::size_t i, const Vec3& f) { Eigen::Map<Vec3>(Q.data() + per_node_ * i) += f; };
  const double r = display.radius;
  const bool lines = display.kind == Display::Kind::Lines;
  const std::size_t n = lines ? display.lines.size() : nodes_.size();
  std::vector<Vec3> x(n);
  for (std::size_t k = 0; k < n; ++k)
    x[k] = lines ? Vec3(0.5 * (at(q, display.lines[k][0]) + at(q, display.lines[k][1]))) : Vec3(at(q, k));
  const std::vector<Vec3> flow = step.velocity_at(x);
  const bool limited = resistance.empty();
  double slope = 0.0;
  if (!lines) {
    for (std::size_t i = 0; i < n; ++i) {
      const double mass = limited ? nodes_[i] : 0.0;
      add(i, drag(step, step.scale * flow[i] - velocity(i), std::numbers::pi * r * r, mass, slope));
      if (!limited) resistance[i] += slope * Mat3::Identity();
    }
    return;
  }
  // A node shares its mass among the lines that end in it.
  std::vector<double> ends(nodes_.size(), 0.0);
  for (const auto& [a, b] : display.lines) ends[a] += 1.0, ends[b] += 1.0;
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t a = display.lines[k][0], b = display.lines[k][1];
    const Vec3 along = at(q, b) - at(q, a);
    const double length = along.norm();
    if (!(length > 0.0)) continue;
    const Vec3 e = along / length, air = step.scale * flow[k] - 0.5 * (velocity(a) + velocity(b));
    const double mass = limited ? nodes_[a] / ends[a] + nodes_[b] / ends[b] : 0.0;
    const Vec3 f = 0.5 * drag(step, air - e * e.dot(air), 2.0 * r * length, mass, slope);
    add(a, f), add(b, f);
    if (!limited)
      for (const std::size_t i : {a, b}) resistance[i] += 0.5 * slope * (Mat3::Identity() - e * e.transpose());
  }
}

}  // namespace brim
