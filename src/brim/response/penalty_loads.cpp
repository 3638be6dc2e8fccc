#include <algorithm>
#include <cmath>

#include "brim/core/parallel.h"
#include "brim/response/penalty.h"

// Friction at the start of a sub-step, and updates between its solves: released nodes, and the friction that follows
// from their slip.

namespace brim {

namespace {

/// Slip, relative to the speed at the start of a step, below which it counts as zero: a smaller value would only worsen
/// the conditioning of the solve.
constexpr double kStick = 1e-4;
/// Mean slip of a patch, relative to the viscous limit of friction, up to which a deformable part is first assumed to
/// stick: contact nodes change between two steps, and with them their slip.
constexpr double kNearlyStuck = 40.0;
/// Difference of friction between two solves, relative to its limit, above which it determines the response of the
/// slip.
constexpr double kTellingFriction = 0.02;
/// [m/s] avoids division by zero.
constexpr double kNone = 1e-300;
/// Largest factor on a pair's inverse mass as felt by friction: 3.5 for a ball that slides.
constexpr double kLightest = 8.0;
/// Smallest relative distance of the next slip from both of two bracketing slips.
constexpr double kLeastShare = 0.1;

}  // namespace

void Penalty::set_friction(std::size_t c, double load, const Vec3& tangential, double stick) {
  friction_viscosity_[c] = mu_[c] * std::max(0.0, load) / std::max(tangential.norm(), stick) + drag_[c];
}

void Penalty::set_load(std::size_t c, double load) {
  load_[c] = load;
  set_friction(c, load, slip_after(c, {}), options_.friction_speed);
  action_[c] = {normal_[c], -options_.dt * friction_viscosity_[c], options_.dt * friction_viscosity_[c]};
}

void Penalty::set_bonds(std::vector<Bond> bonds) {
  bonds_ = std::move(bonds);
  for (std::size_t i = 0; i < bonds_.size(); ++i) {
    active_[first_bond() + i] = !bonds_[i].waits;
    settled_ = settled_ && !bonds_[i].one_way;
  }
  idle_ = idle_ && bonds_.empty();
  settle_actions();
}

void Penalty::set_bond_forces(std::span<const Bond> bonds) {
  for (std::size_t i = 0; i < bonds_.size(); ++i) bonds_[i].force = bonds[i].force;
}

Vec3 Penalty::bond_force(std::size_t i, const Vec3& delta) const {
  const Bond& b = bonds_[i];
  return b.force - (b.across * b.n.dot(delta) * b.n + b.along * delta) / options_.dt;
}

void Penalty::update_bonds(std::span<const Vec3> delta, double& changed, double& total) {
  for (std::size_t i = 0; i < bonds_.size(); ++i) {
    Bond& bond = bonds_[i];
    const std::size_t c = first_bond() + i;
    if (!bond.one_way || !(active_[c] || bond.waits)) continue;
    const double load = bond_force(i, delta[c]).dot(bond.n);
    if (active_[c] || load > 0.0) total += std::abs(load);
    if ((load > 0.0) == static_cast<bool>(active_[c])) continue;
    active_[c] = !active_[c];
    bond.waits = false;  // stays released for the step
    changed += std::abs(load);
  }
}

bool Penalty::release_stops(std::span<const Vec3> delta) {
  bool changed = false;
  for (std::size_t i = 0; i < bonds_.size(); ++i) {
    const std::size_t c = first_bond() + i;
    if (!bonds_[i].stops || !active_[c] || !(bond_force(i, delta[c]).dot(bonds_[i].n) < 0.0)) continue;
    active_[c] = 0, bonds_[i].waits = false;
    changed = true;
  }
  if (changed) settle_actions();
  return changed;
}

void Penalty::start_friction(const ContactSet& contacts) {
  parallel_for(contacts.pairs.size(), [&](std::size_t p) { start_friction_of(p, contacts); });
}

void Penalty::start_friction_of(std::size_t p, const ContactSet& contacts) {
  const ContactPair& pair = contacts.pairs[p];
  // The slip below which friction is viscous is at least a share of the speed at the start.
  Vec3 speed = Vec3::Zero();
  bool touching = false;
  for (std::size_t c = pair.begin; c < pair.end; ++c) {
    speed += relative_[c];
    touching = touching || contacts.overlap[c] > 0.0;
  }
  const auto count = static_cast<double>(std::max<std::size_t>(1, pair.end - pair.begin));
  SlipHistory& history = patches_[p].slip;
  history = {};
  history.stick = std::max(options_.friction_speed, kStick * speed.norm() / count);
  // A patch that overlaps already is held by the overlap: other gaps close only as far as the rate predicts.
  const bool deforms = !pairs_[p].rigid;
  const double slack = touching && deforms ? 0.0 : 1.5 * options_.slack / pair.w;
  double load = 0.0, slip = 0.0;
  for (std::size_t c = pair.begin; c < pair.end; ++c) {
    const double after = patches_[p].hardening.at(contacts.overlap[c]).offset - implicit_time_[c] * rate_[c];
    active_[c] = pairs_[p].filled || (scale_[c] > 0.0 && (contacts.overlap[c] > 0.0 || after + slack > 0.0));
    load_[c] = scale_[c] * after;
    load += std::max(0.0, load_[c]), slip += std::max(0.0, load_[c]) * slip_after(c, {}).norm();
  }
  const bool stuck = deforms && slip < kNearlyStuck * history.stick * load;
  for (std::size_t c = pair.begin; c < pair.end; ++c)
    set_friction(c, load_[c], stuck ? Vec3::Zero() : slip_after(c, {}), history.stick);
  history.assumed = std::max(history.stick, stuck || !(load > 0.0) ? 0.0 : slip / load);
}

double Penalty::update_loads(const ContactSet& contacts, std::span<const Vec3> delta) {
  std::vector<double> change(contacts.pairs.size(), 0.0), total(contacts.pairs.size(), 0.0);
  parallel_for(contacts.pairs.size(), [&](std::size_t p) {
    const ContactPair& pair = contacts.pairs[p];
    Patch& patch = patches_[p];
    // Pulling nodes are released; until the next solve they still carry part of the net load, and newly active ones
    // will share it, so friction is scaled to the net.
    double net = 0.0, push = 0.0, come = 0.0;
    const Vec3 origin = pair.begin < pair.end ? contacts.point[pair.begin] : Vec3::Zero();
    Vec3 moment = Vec3::Zero();  // of the net load about the origin, as Σ l x
    patch.let_go.setZero();
    for (std::size_t c = pair.begin; c < pair.end; ++c) {
      const Vec3& n = normal_[c];
      // Loads of filled pairs are given, and their friction follows only once: a fluid's is small, and its last load
      // close.
      if (!pairs_[p].filled)
        load_[c] = scale_[c] * (patch.hardening.at(contacts.overlap[c]).offset - implicit_time_[c] * rate_[c]) -
                   implicit_time_[c] * stiffness_[c] * n.dot(delta[c]);
      if (active_[c]) net += load_[c], moment += load_[c] * (contacts.point[c] - origin);
      if (active_[c] && load_[c] > 0.0) push += load_[c];
    }
    // A patch that pulls as a whole is let go, however slowly it separates: it may hold back what friction lifts.
    const bool pulls = net < -push;
    for (std::size_t c = pair.begin; c < pair.end && !pairs_[p].filled; ++c) {
      const Vec3& n = normal_[c];
      const bool was_active = active_[c];
      const double separation = std::max(n.dot(relative_[c] + delta[c]), n.dot(relative_[c]));
      if (contacts.overlap[c] <= 0.0 || !was_active)
        active_[c] = load_[c] > 0.0;  // scale 0: no load
      else if (load_[c] < 0.0 && (pulls || separation > options_.release_speed))
        active_[c] = 0;
      if (net < 0.0 && was_active && !active_[c]) patch.let_go -= load_[c] * n;
      if (was_active != static_cast<bool>(active_[c])) change[p] += std::abs(load_[c]);
      if (!was_active && active_[c]) come += load_[c];
    }
    total[p] = push;
    const double mean = push > 0.0 ? std::max(0.0, net) / (push + come) : 1.0;
    patch.share = {.scale = mean};
    // A patch of rigid parts acts as a whole: friction has the centre of its net load.
    const std::size_t count = pair.end - pair.begin;
    if (pairs_[p].rigid && !pairs_[p].filled && net > 0.0)
      patch.share = share_about(std::span(contacts.point).subspan(pair.begin, count),
                                std::span(normal_).subspan(pair.begin, count),
                                std::span(load_).subspan(pair.begin, count), net, origin + moment / net);
    patch.found = find_slip(pair, p, delta, mean);
  });
  push_bodies();
  parallel_for(contacts.pairs.size(), [&](std::size_t p) {
    const ContactPair& pair = contacts.pairs[p];
    const FrictionShare& share = patches_[p].share;
    const SlipForecast next = expected_slip(p);
    double load = 0.0, assumed = 0.0;
    for (std::size_t c = pair.begin; c < pair.end; ++c) {
      const Vec3 slip = slip_after(c, delta);
      const double before = friction_viscosity_[c];
      const Vec3 expected = slip + (next.ratio - 1.0) * (pairs_[p].rigid ? next.mean : slip);
      const Vec3 tangential = expected - normal_[c] * normal_[c].dot(expected);
      set_friction(c, share.of(load_[c], contacts.point[c]), tangential, patches_[p].slip.stick);
      load += std::max(0.0, load_[c]), assumed += std::max(0.0, load_[c]) * tangential.norm();
      if (active_[c] && !pairs_[p].filled) change[p] += std::abs(friction_viscosity_[c] - before) * slip.norm();
    }
    patches_[p].slip.assumed = std::max(patches_[p].slip.stick, load > 0.0 ? assumed / load : 0.0);
  });
  double changed = 0.0, load = 0.0;
  update_bonds(delta, changed, load);
  settle_actions();
  for (std::size_t p = 0; p < contacts.pairs.size(); ++p) changed += change[p], load += total[p];
  return load > 0.0 ? changed / load : changed > 0.0 ? 1.0 : 0.0;
}

void Penalty::keep_loads() { kept_active_ = active_, kept_viscosity_ = friction_viscosity_; }

void Penalty::take_back_loads() {
  active_.swap(kept_active_), friction_viscosity_.swap(kept_viscosity_);
  settle_actions();
}

Vec3 Penalty::slip_after(std::size_t c, std::span<const Vec3> delta) const {
  const Vec3 after = delta.empty() ? relative_[c] : Vec3(relative_[c] + delta[c]);
  return after - normal_[c] * normal_[c].dot(after);
}

Vec3 Penalty::mean_slip(const ContactPair& pair, std::span<const Vec3> delta) const {
  double load = 0.0;
  Vec3 sum = Vec3::Zero();
  for (std::size_t c = pair.begin; c < pair.end; ++c) {
    if (!active_[c] || !(load_[c] > 0.0)) continue;
    load += load_[c];
    sum += load_[c] * slip_after(c, delta);
  }
  return load > 0.0 ? Vec3(sum / load) : Vec3::Zero();
}

double Penalty::SlipHistory::keep_between(double next, double found, bool too_much) {
  if (!(assumed > 0.0)) return next;
  const double excess = std::log(found / assumed);
  // While friction is below its limit, only a few nodes slip by jumps: the patch may stick.
  if (excess > 0.0 && !too_much && !(tight.assumed > 0.0)) return next;
  (excess > 0.0 ? tight : loose) = {assumed, excess};
  if (!(tight.assumed > 0.0 && loose.assumed > 0.0)) return next;
  if (tight.assumed >= loose.assumed) {  // loads have changed: earlier results are invalid
    (excess > 0.0 ? loose : tight) = {};
    return next;
  }
  if (next > tight.assumed && next < loose.assumed) return next;
  const double share = std::clamp(tight.excess / (tight.excess - loose.excess), kLeastShare, 1.0 - kLeastShare);
  return tight.assumed * std::pow(loose.assumed / tight.assumed, share);
}

Penalty::SlipFound Penalty::find_slip(const ContactPair& pair, std::size_t p, std::span<const Vec3> delta,
                                      double share) const {
  SlipFound f;
  const PairState& state = pairs_[p];
  f.mean = mean_slip(pair, delta);
  const double size = f.mean.norm();
  double load = 0.0, slip = 0.0;
  for (std::size_t c = pair.begin; c < pair.end; ++c) {
    const Vec3 after = slip_after(c, delta);
    const double speed = after.norm();
    if (action_[c].viscosity > 0.0)
      f.friction += friction_viscosity_[c] * (state.rigid ? f.mean.dot(after) / std::max(size, kNone) : speed);
    if (!active_[c] || !(load_[c] > 0.0)) continue;
    f.most += mu_[c] * share * load_[c];
    load += load_[c], slip += load_[c] * speed;
  }
  f.speed = state.rigid ? size : load > 0.0 ? slip / load : 0.0;
  // Friction below its limit grows no further than to where the slip ends.
  const double light = options_.dt * (state.inverse_mass[0] + state.inverse_mass[1]), excess = f.friction - f.most;
  if (state.rigid && size > 0.0) f.beyond = (light > 0.0 ? std::max(excess, -size / light) : excess) * f.mean / size;
  return f;
}

void Penalty::push_bodies() {
  std::int32_t last = -1;
  for (const PairState& pair : pairs_) last = std::max({last, pair.body[0], pair.body[1]});
  pushed_.assign(static_cast<std::size_t>(last + 1), Vec3::Zero());
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    const PairState& state = pairs_[p];
    const Vec3 gone = patches_[p].found.beyond + patches_[p].let_go;
    pushed_[static_cast<std::size_t>(state.body[0])] += options_.dt * state.inverse_mass[0] * gone;
    pushed_[static_cast<std::size_t>(state.body[1])] -= options_.dt * state.inverse_mass[1] * gone;
  }
}

Penalty::SlipForecast Penalty::expected_slip(std::size_t p) {
  const PairState& state = pairs_[p];
  SlipHistory& h = patches_[p].slip;
  // Friction changes the slip of rigid parts as a whole, and leaves their rotation; of deformable parts each node's
  // own.
  SlipForecast f;
  f.mean = patches_[p].found.mean;
  const double found = patches_[p].found.speed, friction = patches_[p].found.friction, most = patches_[p].found.most;
  if (!(found > 0.0)) return f;
  // A sliding pair is left with v = A − b F by the friction F. Two solves with different friction give b, which is at
  // least that of the whole masses; Coulomb's limit then leaves A − b µN if that is positive; else it sticks.
  const double whole = options_.dt * (state.inverse_mass[0] + state.inverse_mass[1]),
               less = h.friction_before - friction;
  const double secant = (found - h.found_before) / less;
  const bool tells = h.solves > 0 && std::abs(less) > kTellingFriction * most && secant > whole;
  const double b = tells ? std::min(secant, kLightest * whole) : whole;
  // If a part deforms and both move, masses alone underestimate b, but they serve to leave the state of sticking where
  // friction is beyond its limit. Not for sheets: one pressed between heavy bodies would alternate between sticking and
  // slipping. What links hold does not move by friction (leave_to_links).
  const bool one_moves = state.inverse_mass[0] == 0.0 || state.inverse_mass[1] == 0.0;
  double next = found + b * (friction - most);
  if (const double size = f.mean.norm(); size > 0.0) {
    // What other contacts of the two bodies will give way or hold.
    const auto [a, other] = state.body;
    const auto [light_a, light_b] = state.inverse_mass;
    next += (f.mean / size)
                .dot(pushed_[static_cast<std::size_t>(a)] - pushed_[static_cast<std::size_t>(other)] -
                     options_.dt * (light_a + light_b) * patches_[p].found.beyond);
  }
  if (tells || state.rigid || one_moves || (friction > most && !state.sheet)) f.ratio = std::max(0.0, next / found);
  // If a part deforms, some nodes of a patch stick while others slide, and slip is not linear in friction.
  if (!state.rigid) f.ratio = h.keep_between(f.ratio * found, found, friction > most) / found;
  h.friction_before = friction, h.found_before = found, ++h.solves;
  return f;
}

}  // namespace brim
