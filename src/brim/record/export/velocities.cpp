#include "brim/record/export/velocities.h"

#include <algorithm>
#include <map>

#include "brim/body/moving_display.h"
#include "brim/body/posed_display.h"
#include "brim/core/error.h"

namespace brim::exporting {

namespace {

/// Bodies with a pose and a twist.
bool rigid_kind(const RecordedBody& body) {
  return (body.kind == "rigid" || body.kind == "obstacle" || body.kind == "image_volume") && body.q_size == 7 &&
         body.v_size == 6;
}

std::vector<Vec3f> of_twist(const RecordedBody& body, const State& state, const std::vector<Vec3f>& x) {
  const double *q = state.q.data() + body.q_offset, *v = state.v.data() + body.v_offset;
  const Vec3 center(q[0], q[1], q[2]), velocity(v[0], v[1], v[2]), spin(v[3], v[4], v[5]);
  std::vector<Vec3f> u;
  u.reserve(x.size());
  for (const Vec3f& p : x) {
    const Vec3 arm = p.cast<double>() - center;
    u.push_back((velocity + spin.cross(arm)).cast<float>());
  }
  return u;
}

/// u = J v by the map of a part at points of its surface.
void through_map(const Body& body, int part, std::span<const double> v, std::span<const Vec3f> x,
                 std::vector<Vec3f>& u) {
  std::vector<Vec3> points, velocities(x.size());
  for (const Vec3f& p : x) points.push_back(p.cast<double>());
  std::unique_ptr<Map> map;
  body.make_map(part, points, std::vector<std::int32_t>(x.size(), 0), map);
  map->apply(v, velocities);
  for (const Vec3& w : velocities) u.push_back(w.cast<float>());
}

/// Velocities by the body itself; empty for a kind that does not know them.
std::vector<Vec3f> by_body(const Body& body, std::span<const double> v, const std::vector<Vec3f>& x) {
  std::vector<Vec3f> u;
  if (const auto* moving = dynamic_cast<const MovingDisplay*>(&body)) {
    u.resize(x.size());
    moving->display_velocities(v, x, u);
  } else if (const PosedDisplay* posed = posed_display(body);
             posed && posed->piece_count() == static_cast<std::size_t>(body.part_count())) {
    std::size_t first = 0;
    for (std::size_t i = 0; i < posed->piece_count(); ++i) {
      const std::size_t n = posed->piece(i).surface().vertices.size();
      through_map(body, static_cast<int>(i), v, std::span(x).subspan(first, n), u);
      first += n;
    }
  }
  return u;
}

}  // namespace

Velocities::Velocities(const RunReader& run, WorldAt world_at)
    : run_(run), world_at_(std::move(world_at)), own_(run.bodies().size()) {}

VelocitySource Velocities::source(int body) { return own(body).source; }

const Velocities::Own& Velocities::own(int body) {
  std::optional<Own>& own = own_[static_cast<std::size_t>(body)];
  if (!own) own = find(body);
  return *own;
}

Velocities::Own Velocities::find(int body) {
  const RecordedBody& recorded = run_.bodies()[static_cast<std::size_t>(body)];
  Own found;
  if (!recorded.changing && rigid_kind(recorded)) {
    found.source = VelocitySource::Twist;
  } else if (!recorded.changing && find_nodes(body, found)) {
    found.source = VelocitySource::Nodes;
  } else if (const World* world = this->world(0);
             world && by_body(world->body(body), world->v(body), run_.positions(body, 0)).size() ==
                          run_.positions(body, 0).size()) {
    found.source = VelocitySource::Map;
  } else if (!recorded.changing) {
    found.source = VelocitySource::Differences;
  }
  return found;
}

/// Finds the node of each vertex by its position in the first frame. Nodes at one place may move apart later, so
/// of_nodes() compares again.
bool Velocities::find_nodes(int body, Own& found) const {
  const RecordedBody& recorded = run_.bodies()[static_cast<std::size_t>(body)];
  const std::size_t nodes = recorded.q_size / 3;
  found.stride = recorded.kind == "points" ? 6 : 3;  // grains have their spin behind each velocity
  if (nodes == 0 || recorded.q_size != 3 * nodes || recorded.v_size != found.stride * nodes) return false;
  const State state = run_.state(0);
  const double* q = state.q.data() + recorded.q_offset;
  std::map<std::array<float, 3>, std::size_t> node_at;
  const auto key = [](const Vec3f& x) { return std::array{x[0], x[1], x[2]}; };
  for (std::size_t i = 0; i < nodes; ++i) node_at.emplace(key(Vec3(q + 3 * i).cast<float>()), i);
  const std::vector<Vec3f> x = run_.positions(body, 0);
  for (std::size_t k = 0; k < x.size(); ++k) {
    // Nodes that are vertices in their own order, where some may lie at one place.
    if (x.size() == nodes && Vec3f(Vec3(q + 3 * k).cast<float>()) == x[k]) {
      found.node.push_back(k);
      continue;
    }
    const auto at = node_at.find(key(x[k]));
    if (at == node_at.end()) return false;
    found.node.push_back(at->second);
  }
  return true;
}

const World* Velocities::world(std::int64_t frame) {
  if (!world_at_) return nullptr;
  try {
    return &world_at_(frame);
  } catch (const InputError&) {
    world_at_ = {};  // a mesh that the scene names is gone, or a plugin is missing
    return nullptr;
  }
}

std::vector<Vec3f> Velocities::at(int body, std::int64_t frame, const State& state, const std::vector<Vec3f>& x) {
  const Own& own = this->own(body);
  if (own.source == VelocitySource::None) return {};
  if (run_.still(body)) return std::vector<Vec3f>(x.size(), Vec3f::Zero());
  std::vector<Vec3f> u;
  if (own.source == VelocitySource::Twist) u = of_twist(run_.bodies()[static_cast<std::size_t>(body)], state, x);
  if (own.source == VelocitySource::Nodes) u = of_nodes(own, body, state, x);
  if (u.empty() && own.source != VelocitySource::Differences) u = of_world(body, frame, x);
  return u.size() == x.size() ? u : differences(body, frame, x.size());
}

/// Empty where a vertex is not at its node.
std::vector<Vec3f> Velocities::of_nodes(const Own& own, int body, const State& state,
                                        const std::vector<Vec3f>& x) const {
  const RecordedBody& recorded = run_.bodies()[static_cast<std::size_t>(body)];
  const double *q = state.q.data() + recorded.q_offset, *v = state.v.data() + recorded.v_offset;
  std::vector<Vec3f> u;
  u.reserve(x.size());
  for (std::size_t k = 0; k < x.size(); ++k) {
    const std::size_t n = own.node[k];
    if (Vec3f(Vec3(q + 3 * n).cast<float>()) != x[k]) return {};
    u.push_back(Vec3(v + own.stride * n).cast<float>());
  }
  return u;
}

std::vector<Vec3f> Velocities::of_world(int body, std::int64_t frame, const std::vector<Vec3f>& x) {
  const World* world = this->world(frame);
  return world ? by_body(world->body(body), world->v(body), x) : std::vector<Vec3f>();
}

/// From the frame before to that after, as far as the run has them with the body.
std::vector<Vec3f> Velocities::differences(int body, std::int64_t frame, std::size_t vertices) const {
  const auto there = [&](std::int64_t f) {
    if (f < 0 || f >= run_.frames()) return false;
    const std::vector<int> removed = run_.removed(f);
    return !std::ranges::binary_search(removed, body);
  };
  const std::int64_t before = there(frame - 1) ? frame - 1 : frame, after = there(frame + 1) ? frame + 1 : frame;
  const std::vector<Vec3f> x0 = run_.positions(body, before), x1 = run_.positions(body, after);
  const double dt = run_.time(after) - run_.time(before);
  std::vector<Vec3f> u(vertices, Vec3f::Zero());
  if (!(dt > 0.0) || x0.size() != vertices || x1.size() != vertices) return u;
  for (std::size_t i = 0; i < u.size(); ++i) u[i] = (x1[i] - x0[i]) / static_cast<float>(dt);
  return u;
}

}  // namespace brim::exporting
