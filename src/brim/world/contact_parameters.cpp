#include "brim/world/contact_parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>
#include <unordered_set>

#include "brim/body/movable.h"
#include "brim/body/rigid_frame.h"
#include "brim/body/solid_of.h"
#include "brim/body/spinning_balls.h"
#include "brim/core/interface_of.h"
#include "brim/world/fill_stage.h"

namespace brim {

namespace {

/// Precedence: the pair's own response, then a body's "constraint", then a body's "penalty", then the world's.
Response choose_response(Response pair, Response a, Response b, Response world) {
  if (pair != Response::Inherit) return pair;
  if (a == Response::Constraint || b == Response::Constraint) return Response::Constraint;
  if (a == Response::Penalty || b == Response::Penalty) return Response::Penalty;
  return world;
}

/// Factor on the stiffness required by the loads, for the faces of a rigid body on a fixed part: an edge that carries
/// the whole weight then sinks in so little that the body does not lean.
constexpr double kFaces = 40.0;

/// Stiffness relative to the chosen one above which contact may throw. Energy gained by contact nodes within a step,
/// relative to all energy before, for boxes and soft cubes dropped by 0.4 m: 1.6 to 2.4 at a factor of 10; 4 to 15 at
/// 30; 8 to 64 at 60. At 300 soft cubes leave faster than they came.
constexpr double kThrowing = 30.0;

/// Largest factor by which the loads of others raise the stiffness over that required by the lighter of two bodies.
/// Balls of 40 and 400 kg and 0.2 m that roll onto a cloth of 0.12 kg/m² on the floor throw it by 4 and 25 m without a
/// bound, by 4 m at 10,000, and not at 3,000. A box of 500 kg and 0.25 m fallen on it overlaps at rest by 0.06 voxel at
/// 3,000, and by 1.6 at 1,000.
constexpr double kBearable = 3000.0;

/// Factor on the stiffness of self-contact over that required by one layer: folds lie on each other, and impact on an
/// edge has the mass of everything that stands on it. A strip of 1.2 m that falls on its edge ends with folds that
/// overlap by 1.2 voxels at factors of 1 and 3, and by 0.4 at 10 and 30.
constexpr double kFolds = 10.0;

/// [Pa] without any weight: any contact may be this stiff.
constexpr double kWeightless = 1e6;
/// [voxels] a step's motion of two parts' centres past each other up to which their contact stays in its place, or its
/// share of the fastest motion about the centres.
constexpr double kStays = 0.1, kTurns = 0.2;

/// kFaces for a pair: a round contact keeps the stiffness required by the loads. With a stiffer one the load of a
/// rolling body fluctuates more as nodes appear and vanish under it.
double faces_of(const ContactPair& pair) {
  const double flat = 1.0 - pair.roundness;
  return 1.0 + (kFaces - 1.0) * flat * flat;
}

/// [1/kg] Lower bound of what a force moves the body by: that of its mass, zero where something may hold it.
double inverse_mass_of(const WorldPart& p) {
  const auto* movable = interface_of<Movable>(*p.body);
  const bool held = is_fixed(p) || (movable != nullptr && *movable->bound() != 0);
  return held ? 0.0 : 1.0 / p.body->mass();
}

/// A rigid body. Links of trees are not: what hangs from one between others gains energy when it is guided.
bool is_frame(const WorldPart& p) { return interface_of<RigidFrame>(*p.body) != nullptr; }

}  // namespace

bool is_rigid(const WorldPart& p) { return p.body->v_size() <= 6 * static_cast<std::size_t>(p.body->part_count()); }

bool has_distance(const WorldPart& p) { return solid_of(*p.body, p.index) != nullptr; }

Response default_response(const WorldPart& a, const WorldPart& b, const WorldOptions& options) {
  if (options.response != Response::Inherit) return options.response;
  return options.stiffness == 0.0 && a.solid && b.solid ? Response::Constraint : Response::Penalty;
}

bool meet_by_rows(const WorldPart& a, const WorldPart& b, const WorldOptions& options) {
  if (a.info.conforming || b.info.conforming) return false;
  Response own = Response::Inherit;
  if (!options.pair_materials.empty()) {
    const auto key = std::minmax(a.info.material.name, b.info.material.name);
    const auto it = options.pair_materials.find({key.first, key.second});
    if (it != options.pair_materials.end()) own = it->second.response;
  }
  return choose_response(own, a.info.material.response, b.info.material.response, default_response(a, b, options)) ==
         Response::Constraint;
}

bool meet_by_rigid_rows(const WorldPart& a, const WorldPart& b, const WorldOptions& options) {
  return is_rigid(a) && is_rigid(b) && meet_by_rows(a, b, options);
}

void ContactParameters::start(std::span<const WorldPart> parts, std::span<const double> v,
                              std::span<const std::size_t> first_v, const WorldOptions& options, double h0) {
  std::vector<double> speed(parts.size());
  for (std::size_t p = 0; p < parts.size(); ++p) speed[p] = speed_bound(parts[p], velocities_of(parts[p], v, first_v));
  const std::vector<Loads> loads = estimate_loads(parts, speed, options.environment);
  heaviest_ = {};
  for (const Loads& l : loads) heaviest_.raise_to(l);
  groups_.start(parts, loads);
  loads_width_ = options.ramp_voxels * h0;
  const double chosen = choose_stiffness(heaviest_, loads_width_, options.time_step);
  stiffness_ = options.stiffness > 0.0 ? options.stiffness : chosen > 0.0 ? chosen : kWeightless;
}

double ContactParameters::stiffness_under(const Loads& loads, const PartInfo& a, const PartInfo& b, double dt) const {
  double k = choose_stiffness(loads, loads_width_, dt);
  if (!(k > 0.0)) k = kWeightless;
  if (a.conforming || b.conforming)
    return conforming_stiffness(k, std::min(a.conforming ? a.modulus : b.modulus, b.conforming ? b.modulus : a.modulus),
                                loads);
  return soften_stiffness(k, std::min(a.modulus, b.modulus), loads, loads_width_, dt);
}

double ContactParameters::chosen_stiffness(const WorldPart& a, const WorldPart& b, double dt) const {
  const double k = stiffness_under(groups_.between(a, b), a.info, b.info, dt);
  if (a.info.conforming || b.info.conforming) return k;
  double own = std::numeric_limits<double>::infinity();
  for (const WorldPart* p : {&a, &b})
    if (!is_fixed(*p)) own = std::min(own, stiffness_under(groups_.own(*p), a.info, b.info, dt));
  return std::min(k, kBearable * own);
}

double ContactParameters::growth_of(const WorldPart& a, const WorldPart& b, double stiffness,
                                    const WorldOptions& options) const {
  if (a.info.conforming || b.info.conforming || std::min(a.info.modulus, b.info.modulus) > 0.0) return 1.0;
  double own = std::numeric_limits<double>::infinity();
  for (const WorldPart* p : {&a, &b}) {
    if (is_fixed(*p)) continue;
    Loads alone = groups_.own(*p);
    alone.pressure = sheet_pull(options.environment) * alone.areal_mass;  // without what lies above at the start
    own = std::min(own, stiffness_under(alone, a.info, b.info, options.time_step));
  }
  return std::max(1.0, kBearable * own / stiffness);
}

PairMaterial ContactParameters::material_of(const WorldPart& part_a, const WorldPart& part_b,
                                            const WorldOptions& options) const {
  const Material &a = part_a.info.material, &b = part_b.info.material;
  const auto key = std::minmax(a.name, b.name);
  const auto it = options.pair_materials.find({key.first, key.second});
  PairMaterial m = it != options.pair_materials.end() ? it->second : PairMaterial{};
  if (m.friction < 0.0) m.friction = std::sqrt(a.friction * b.friction);
  if (m.restitution < 0.0) m.restitution = std::max(a.restitution, b.restitution);
  if (m.rolling_resistance < 0.0) m.rolling_resistance = std::max(a.rolling_resistance, b.rolling_resistance);
  m.response = choose_response(m.response, a.response, b.response, default_response(part_a, part_b, options));
  if (m.stiffness == 0.0) m.stiffness = options.stiffness;
  return m;
}

void ContactParameters::warn_of_restitution(std::span<const WorldPart> parts, const WorldOptions& options,
                                            StepReport& report) const {
  std::map<std::string, std::vector<const WorldPart*>> by_material;  // one part of each kind of response
  for (const WorldPart& p : parts) {
    auto& all = by_material[p.info.material.name];
    const auto same = [&](const WorldPart* q) {
      return is_rigid(*q) == is_rigid(p) && is_fixed(*q) == is_fixed(p) && q->solid == p.solid &&
             q->info.conforming == p.info.conforming && q->info.material.response == p.info.material.response;
    };
    if (std::ranges::none_of(all, same)) all.push_back(&p);
  }
  // A restitution that was given to a deformable body, or to a pair; not that of a ball which meets one by chance.
  const auto unheard = [&](const WorldPart& a, const WorldPart& b) {
    if (is_rigid(a) && is_rigid(b)) return false;
    const bool rows =
        !a.info.conforming && !b.info.conforming && material_of(a, b, options).response == Response::Constraint;
    return !rows;
  };
  const auto tell = [&](double e, const std::string& whose) {
    report.warnings.push_back(
        {report.time, "no_restitution",
         fmt::format("the restitution {:g} of {} has no effect on deformable bodies, grains and fluids: they meet "
                     "others by penalties, which have none; give them the response \"constraint\", or leave it out",
                     e, whose)});
  };
  for (const auto& [name, own] : by_material) {
    const auto soft = std::ranges::find_if(
        own, [](const WorldPart* p) { return !is_rigid(*p) && p->info.material.restitution > 0.0; });
    if (soft == own.end()) continue;
    const auto meets = [&](const WorldPart& b) { return b.body_index != (*soft)->body_index && unheard(**soft, b); };
    if (std::ranges::any_of(parts, meets)) tell((*soft)->info.material.restitution, fmt::format("'{}'", name));
  }
  for (const auto& [names, pair] : options.pair_materials) {
    if (!(pair.restitution > 0.0)) continue;
    const auto first = by_material.find(names.first), second = by_material.find(names.second);
    if (first == by_material.end() || second == by_material.end()) continue;
    // Where solids of these materials heed it, it is meant for them.
    bool lost = false, heeded = false;
    for (const WorldPart* one : first->second)
      for (const WorldPart* other : second->second) {
        if (is_fixed(*one) && is_fixed(*other)) continue;
        const bool without = unheard(*one, *other);
        lost = lost || without, heeded = heeded || !without;
      }
    if (lost && !heeded) tell(pair.restitution, fmt::format("'{}' and '{}'", names.first, names.second));
  }
}

void ContactParameters::warn(std::span<const WorldPart> parts, const WorldOptions& options, StepReport& report) const {
  warn_of_restitution(parts, options, report);
  // One part represents all with its material and modulus, solid or not.
  std::map<std::tuple<std::string, double, bool>, const WorldPart*> example;
  for (const WorldPart& p : parts)
    if (!p.info.conforming) example.try_emplace({p.info.material.name, p.info.modulus, p.solid}, &p);
  std::set<std::pair<std::string, std::string>> said, unheard;
  const bool rigid = std::ranges::any_of(parts, [](const WorldPart& p) { return is_rigid(p) && !is_fixed(p); });
  for (const auto& [key_a, a] : example)
    for (const auto& [key_b, b] : example) {
      const double E = std::min(a->info.modulus, b->info.modulus);
      const std::string &name_a = a->info.material.name, &name_b = b->info.material.name;
      const PairMaterial m = material_of(*a, *b, options);
      if (m.response == Response::Constraint) continue;
      if (m.restitution > 0.0 && rigid && std::isinf(E) && unheard.insert(std::minmax(name_a, name_b)).second)
        report.warnings.push_back(
            {report.time, "no_restitution",
             fmt::format(
                 "the restitution {:g} of '{}' and '{}' has no effect: they meet by penalties, which have none; "
                 "give the response \"constraint\" to the pair, or to the world",
                 m.restitution, name_a, name_b)});
      if (m.stiffness == 0.0) continue;
      const double chosen = stiffness_under(heaviest_, a->info, b->info, options.time_step);
      const bool soft = m.stiffness < kTellingModulus * E && !std::isinf(E);
      const bool stiff = m.stiffness > kThrowing * chosen;
      if (!soft && !stiff) continue;
      if (!said.insert(std::minmax(name_a, name_b)).second) continue;
      if (stiff) {
        report.warnings.push_back(
            {report.time, "stiff_contact",
             fmt::format("contact of '{}' and '{}' is {:.2g} Pa, more than {:g} times the {:.2g} Pa that their loads "
                         "ask for: nodes that come into contact bring energy in; take the least stiffness that "
                         "keeps them apart, or leave it out to have it chosen",
                         name_a, name_b, m.stiffness, kThrowing, chosen)});
        continue;
      }
      report.warnings.push_back({report.time, "soft_contact",
                                 fmt::format("contact of '{}' and '{}' is {:.2g} Pa, less than {:g} times the modulus "
                                             "{:.2g} Pa of the softer body: it is "
                                             "contact that gives; leave the stiffness out to have it chosen",
                                             name_a, name_b, m.stiffness, kTellingModulus, E)});
    }
}

ConstraintPair ContactParameters::constraint_between(const WorldPart& a, const WorldPart& b,
                                                     const WorldOptions& options) const {
  const PairMaterial m = material_of(a, b, options);
  return {m.response == Response::Constraint, m.friction, m.restitution, is_rigid(a) && is_rigid(b)};
}

void ContactParameters::choose(std::span<const WorldPart> parts, std::span<const double> v,
                               std::span<const std::size_t> first_v, const WorldOptions& options,
                               const ContactStage& stage) {
  const std::span<const ContactPair> pairs = stage.contacts().pairs;
  if (!pairs.empty()) groups_.find(parts, stage);
  penalties_.resize(pairs.size());
  constraints_.resize(pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const WorldPart &a = parts[pairs[i].part_a], &b = parts[pairs[i].part_b];
    const PairMaterial m = material_of(a, b, options);
    const bool filled = fills(a, b);
    // A conforming part has no few points by which rows could hold it.
    const bool conforming = a.info.conforming || b.info.conforming;
    const bool itself = pairs[i].part_a == pairs[i].part_b;
    const bool constrained = !conforming && !itself && m.response == Response::Constraint;
    const bool rigid = is_rigid(a) && is_rigid(b);
    constraints_[i] = {constrained, m.friction, m.restitution, rigid,
                       rigid         ? FixedPart::None
                       : is_fixed(a) ? FixedPart::A
                       : is_fixed(b) ? FixedPart::B
                                     : FixedPart::None};
    const bool hard = std::isinf(a.info.modulus) && std::isinf(b.info.modulus);
    const bool fixed = is_fixed(a) || is_fixed(b);
    double stiffness = 0.0, growth = 1.0;
    if (!constrained && !filled && !(is_fixed(a) && is_fixed(b))) {
      stiffness = m.stiffness > 0.0 ? m.stiffness : chosen_stiffness(a, b, options.time_step);
      if (hard && fixed && !(m.stiffness > 0.0)) stiffness *= faces_of(pairs[i]);
      if (itself && !(m.stiffness > 0.0)) stiffness *= kFolds;
      if (!itself && !(m.stiffness > 0.0)) growth = growth_of(a, b, stiffness, options);
    }
    const Vec3 velocity_a = a.body->mean_velocity(a.index, velocities_of(a, v, first_v)),
               velocity_b = b.body->mean_velocity(b.index, velocities_of(b, v, first_v));
    const bool solid = hard && rigid;  // rods do not yield to pressure, but they bend
    bool stay = false;
    if (solid && stiffness > 0.0) {
      const double travel = (velocity_a - velocity_b).norm(),
                   turn = a.body->relative_speed_bound(a.index, velocities_of(a, v, first_v)) +
                          b.body->relative_speed_bound(b.index, velocities_of(b, v, first_v));
      stay = travel < std::max(kStays * pairs[i].h / options.time_step, kTurns * turn);
    }
    const auto balls = [](const WorldPart& part) { return interface_of<SpinningBalls>(*part.body) != nullptr; };
    const bool sheet = a.info.modulus == 0.0 || b.info.modulus == 0.0;
    // Both solids of a pair that stays, or the convex one on which a sheet or grains lie.
    const bool grains = balls(a) || balls(b), laid = grains || (sheet && !rigid);
    const auto known = [&](std::int32_t part) {
      const CubeSide* side = stay || laid ? stage.solid(part) : nullptr;
      return side != nullptr && (stay || side->solid->convex() != nullptr) ? side : nullptr;
    };
    penalties_[i] = {
        .stiffness = stiffness,
        .friction = m.friction,
        .mean_velocity_a = velocity_a,
        .mean_velocity_b = velocity_b,
        .conforming = {a.info.conforming, b.info.conforming},
        .rigid = solid,
        .filled = filled,
        .inverse_mass = {inverse_mass_of(a), inverse_mass_of(b)},
        .body = {a.body_index, b.body_index},
        .fixed = fixed,
        .firm =
            fixed || rigid || (is_rigid(a) != is_rigid(b) && std::isinf(a.info.modulus) != std::isinf(b.info.modulus)),
        .guide = !solid && (fixed || is_frame(a) != is_frame(b)),
        .sheet = sheet,
        .balls = grains,
        .growth = growth,
        .solids = {known(pairs[i].part_a), known(pairs[i].part_b)},
    };
  }
}

void ContactParameters::leave_to_links(std::span<const WorldPart> parts, const ContactSet& contacts,
                                       std::size_t first) {
  std::unordered_set<std::int32_t> linked;
  for (std::size_t i = first; i < penalties_.size(); ++i)
    for (const std::int32_t part : {contacts.pairs[i].part_a, contacts.pairs[i].part_b})
      linked.insert(parts[part].body_index);
  for (std::size_t i = 0; i < first && !linked.empty(); ++i)
    for (std::size_t side = 0; side < 2; ++side)
      if (linked.contains(penalties_[i].body[side])) penalties_[i].inverse_mass[side] = 0.0;
  for (std::size_t i = first; i < penalties_.size(); ++i) {
    penalties_[i] = PairState{};
    // Without gradients there are no normals and no loads.
    penalties_[i].conforming = {true, false};
    penalties_[i].filled = true;
    constraints_[i] = ConstraintPair{};
  }
}

}  // namespace brim
