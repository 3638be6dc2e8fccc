#include "brim/world/load_groups.h"

#include <algorithm>

#include "brim/body/walled.h"
#include "brim/core/interface_of.h"

namespace brim {

namespace {

/// Relative momentum of a rigid motion that may be missing for a body free to make it: rounding.
constexpr double kMissed = 1e-9;

/// Largest factor on the own loads of a body that only rests on others: contact ten times stiffer than chosen throws
/// nothing, and in a stack of up to ten equal bodies all contacts are as stiff as the lowest.
constexpr double kResting = 10.0;

Loads several_within(const Loads& l, double times, const Loads& most) {
  return {std::min(times * l.pressure, most.pressure), std::min(times * l.areal_mass, most.areal_mass),
          std::min(times * l.impact_energy, most.impact_energy)};
}

/// True when a body cannot move as a whole in every direction: it has fixed nodes or a fixed base, or walls hold it.
bool is_pinned(const Body& body) {
  if (interface_of<Walled>(body) != nullptr) return true;
  const double m = body.mass();
  std::vector<double> motion(body.v_size());
  for (int axis = 0; axis < 3; ++axis) {
    std::fill(motion.begin(), motion.end(), 0.0);
    if (!body.rigid_motion(Vec3::Unit(axis), Vec3::Zero(), motion)) return true;
    body.filter(motion);
    if (!((body.linear_momentum(motion) - m * Vec3::Unit(axis)).norm() <= kMissed * m)) return true;
  }
  return false;
}

}  // namespace

void LoadGroups::start(std::span<const WorldPart> parts, std::span<const Loads> loads) {
  std::size_t bodies = 0;
  for (const WorldPart& p : parts) bodies = std::max(bodies, static_cast<std::size_t>(p.body_index) + 1);
  own_.assign(bodies, {}), pinned_.assign(bodies, 0);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto b = static_cast<std::size_t>(parts[i].body_index);
    own_[b].raise_to(loads[i]);
    if (parts[i].index == 0 && !is_fixed(parts[i])) pinned_[b] = is_pinned(*parts[i].body);
  }
}

void LoadGroups::touch(const WorldPart& a, const WorldPart& b) {
  const bool in_fluid = a.info.conforming || b.info.conforming;
  if (!is_fixed(a) && (is_fixed(b) || in_fluid)) held_[static_cast<std::size_t>(a.body_index)] = 1;
  if (!is_fixed(b) && (is_fixed(a) || in_fluid)) held_[static_cast<std::size_t>(b.body_index)] = 1;
  if (is_fixed(a) || is_fixed(b) || a.body_index == b.body_index) return;
  edges_.emplace_back(a.body_index, b.body_index);
  edges_.emplace_back(b.body_index, a.body_index);
}

void LoadGroups::find(std::span<const WorldPart> parts, const ContactStage& stage) {
  held_ = pinned_;
  edges_.clear();
  for (const ContactPair& p : stage.contacts().pairs)
    if (p.begin < p.end) touch(parts[p.part_a], parts[p.part_b]);
  stage.rigid().for_pairs([&](std::int32_t a, std::int32_t b) { touch(parts[a], parts[b]); });
  std::sort(edges_.begin(), edges_.end());
  const std::size_t n = own_.size();
  first_edge_.assign(n + 1, 0);
  for (const auto& [from, to] : edges_) ++first_edge_[static_cast<std::size_t>(from) + 1];
  for (std::size_t b = 0; b < n; ++b) first_edge_[b + 1] += first_edge_[b];

  order_.assign(n, -1), parent_.assign(n, -1), visited_.clear();
  // Starts from held bodies, so that bodies visited later rest on those visited before.
  for (const bool held : {true, false})
    for (std::size_t b = 0; b < n; ++b)
      if (order_[b] < 0 && (held_[b] != 0 || !held)) visit(static_cast<std::int32_t>(b));
  share();
}

void LoadGroups::visit(std::int32_t root) {
  std::vector<std::size_t> next;  // next edge to visit, for each body from the root to b
  const auto enter = [&](std::int32_t b) {
    order_[b] = static_cast<std::int32_t>(visited_.size());
    visited_.push_back(b);
    next.push_back(first_edge_[b]);
  };
  enter(root);
  for (std::int32_t b = root; b >= 0;) {
    if (next.back() == first_edge_[b + 1]) {
      next.pop_back();
      b = parent_[b];
      continue;
    }
    const std::int32_t to = edges_[next.back()++].second;
    if (order_[to] >= 0) continue;
    parent_[to] = b;
    enter(b = to);
  }
}

void LoadGroups::share() {
  // From the leaves up: the load that rests on each body, and the first visited body that any of it touches.
  carried_ = own_;
  std::vector<std::int32_t> first = order_;
  for (auto it = visited_.rbegin(); it != visited_.rend(); ++it) {
    const std::int32_t b = *it, parent = parent_[b];
    bool by_parent = false;  // the one contact with the parent by which b was reached
    for (std::size_t e = first_edge_[b]; e < first_edge_[b + 1]; ++e) {
      const std::int32_t to = edges_[e].second;
      if (to != parent || by_parent) first[b] = std::min(first[b], order_[to]);
      by_parent = by_parent || to == parent;
    }
    if (parent < 0) continue;
    first[parent] = std::min(first[parent], first[b]);
    held_[parent] |= held_[b];
    carried_[parent].raise_to(carried_[b]);
  }
  // From the roots down: a body that does not just rest on its parent carries all that its parent does.
  bool on_ground = false;
  for (const std::int32_t b : visited_) {
    const std::int32_t parent = parent_[b];
    if (parent < 0) {
      on_ground = held_[b] != 0;
      continue;
    }
    const bool rests = on_ground && held_[b] == 0 && first[b] == order_[b];
    carried_[b] = rests ? several_within(carried_[b], kResting, carried_[parent]) : carried_[parent];
  }
}

const Loads& LoadGroups::between(const WorldPart& a, const WorldPart& b) const {
  const auto i = static_cast<std::size_t>(a.body_index), j = static_cast<std::size_t>(b.body_index);
  if (is_fixed(a) || is_fixed(b)) return carried_[is_fixed(a) ? j : i];
  return carried_[order_[i] > order_[j] ? i : j];
}

}  // namespace brim
