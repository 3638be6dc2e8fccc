#include <limits>
#include <memory>
#include <utility>

#include "brim/body/movable_base.h"
#include "brim/world/space.h"
#include "brim/world/world_impl.h"

/// Effects of edits on a world: absent bodies, and changed properties of parts and parameters.
namespace brim {

// ---- absent bodies -------------------------------------------------------------------------------------------------

const Body& World::Impl::own(std::size_t b) const { return out(b) ? *absences[b].other : *bodies.at(b); }

Body* World::Impl::aimed(int b) {
  const auto i = static_cast<std::size_t>(b);
  if (b < 0 || i >= count()) return nullptr;
  if (i < fresh.size()) fresh[i] = 0;  // the energy of its drives is another
  return out(i) ? absences[i].other.get() : bodies[i].get();
}

void World::Impl::count_state() {
  first_q.assign(1, 0), first_v.assign(1, 0);
  for (const auto& body : bodies) {
    first_q.push_back(first_q.back() + body->q_size());
    first_v.push_back(first_v.back() + body->v_size());
  }
  for (WorldPart& p : parts) p.body = bodies[static_cast<std::size_t>(p.body_index)].get();
  sleep.follow(bodies);
  constraints.forget_bodies();
  fresh.clear();
}

std::span<const double> World::Impl::kept_q(std::size_t b) const {
  return out(b) ? std::span(absences[b].q) : std::span(state.q).subspan(first_q[b], first_q[b + 1] - first_q[b]);
}

std::span<const double> World::Impl::kept_v(std::size_t b) const {
  return out(b) ? std::span(absences[b].v) : std::span(state.v).subspan(first_v[b], first_v[b + 1] - first_v[b]);
}

const State& World::Impl::whole_state() {
  if (edits.removed.empty()) return state;
  if (!std::exchange(whole_is_old, false)) return whole;
  whole.time = state.time, whole.step = state.step;
  whole.warm_start = state.warm_start, whole.wiring = state.wiring;
  gather_whole(whole.q, whole.v);
  return whole;
}

void World::Impl::gather_whole(std::vector<double>& all_q, std::vector<double>& all_v) const {
  all_q.clear(), all_v.clear();
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const std::span<const double> qb = kept_q(b), vb = kept_v(b);
    all_q.insert(all_q.end(), qb.begin(), qb.end());
    all_v.insert(all_v.end(), vb.begin(), vb.end());
  }
}

void World::Impl::bring_back() {
  std::vector<double> all_q, all_v;
  gather_whole(all_q, all_v);
  bool any = false;
  for (std::size_t b = 0; b < absences.size(); ++b) {
    if (!out(b)) continue;
    std::swap(bodies[b], absences[b].other);
    absences[b].out = false;
    any = true;
  }
  if (!any) return;
  std::swap(state.q, all_q), std::swap(state.v, all_v);
  count_state();
}

void World::Impl::leave_out() {
  bool any = false;
  absences.resize(bodies.size());
  for (const int number : edits.removed) {
    const auto b = static_cast<std::size_t>(number);
    Absence& absence = absences[b];
    if (absence.out) continue;
    absence.q.assign(q(b).begin(), q(b).end());
    absence.v.assign(v(b).size(), 0.0);
    bodies[b]->update(state.time, absence.q, absence.v);
    // Kept for ever: data cached for one object must not be used for another at the same address.
    if (!absence.other) absence.other = std::make_unique<Space>(bodies[b]->part_count());
    std::swap(bodies[b], absence.other);
    absence.out = true;
    any = true;
  }
  if (any) {
    std::vector<double> left_q, left_v;
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      if (out(b)) continue;
      left_q.insert(left_q.end(), q(b).begin(), q(b).end());
      left_v.insert(left_v.end(), v(b).begin(), v(b).end());
    }
    std::swap(state.q, left_q), std::swap(state.v, left_v);
    count_state();
  }
  whole_is_old = true;
}

// ---- edited properties ---------------------------------------------------------------------------------------------

PartInfo World::Impl::info_of(const WorldPart& p) const {
  PartInfo info = p.body->part(p.index);
  const auto it = edits.materials.find(p.body_index);
  if (it != edits.materials.end()) info.material = it->second;
  if (edits.frozen.contains(p.body_index)) {
    // A frozen body neither yields nor deforms.
    info.areal_mass = 0.0;
    info.modulus = std::numeric_limits<double>::infinity();
    info.conforming = false;
  }
  return info;
}

void World::Impl::set_bases() {
  coupling.forget();
  for (std::size_t i = 0; i < count(); ++i) {
    auto* base = dynamic_cast<MovableBase*>(out(i) ? absences[i].other.get() : bodies[i].get());
    if (base == nullptr) continue;
    const auto moved = edits.bases.find(static_cast<int>(i));
    base->set_base(moved == edits.bases.end() ? Pose{} : moved->second);
  }
  fresh.clear();
}

void World::Impl::follow_edits() {
  if (!edits.bases.empty() || bases_moved) set_bases();
  bases_moved = !edits.bases.empty();
  options.environment.gravity = edits.gravity.value_or(given.environment.gravity);
  options.stiffness = edits.stiffness.value_or(given.stiffness);
  options.pair_materials = given.pair_materials;
  for (const auto& [materials, pair] : edits.pairs) options.pair_materials[materials] = pair;
  options.touch_rules = given.touch_rules;
  rules = {};
  int regions = 0;
  for (const TouchRule& rule : given.touch_rules) rules.add(rule, rule.about_part() ? regions++ : -1);
  for (const Edits::Rule& edit : edits.rules) {
    if (edit.region >= filter.size()) continue;  // a rule unknown to this world
    const TouchRule rule = edit.region < 0 ? edit.rule : filter.rule(edit.region);
    options.touch_rules.push_back(rule);
    rules.add(rule, edit.region);
  }
  keep_apart();
  const auto absent = [&](const WorldPart& p) { return out(static_cast<std::size_t>(p.body_index)); };
  double coarsest = 0.0;
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (!absent(parts[i])) coarsest = std::max(coarsest, part_h[i]);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    WorldPart& p = parts[i];
    p.info = info_of(p);
    p.h = absent(p) ? coarsest : part_h[i];  // absent parts must not be the finest
    p.solid = p.body->immobile() || (is_rigid(p) && has_distance(p));
    p.frozen = edits.frozen.contains(p.body_index);
    p.sides = rules.sides(p.body->name()), p.rules = &rules;
  }
  stage.rigid().start(parts, laws, options);
}

}  // namespace brim
