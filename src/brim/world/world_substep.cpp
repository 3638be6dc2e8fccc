#include <algorithm>
#include <cmath>
#include <optional>

#include "brim/body/keeps_energy.h"
#include "brim/body/spinning_balls.h"
#include "brim/core/interface_of.h"
#include "brim/core/parallel.h"
#include "brim/core/profile.h"
#include "brim/core/stop.h"
#include "brim/core/stopwatch.h"
#include "brim/world/ball_points.h"
#include "brim/world/momentum_check.h"
#include "brim/world/pair_reports.h"
#include "brim/world/rolling_resistance.h"
#include "brim/world/row_memory.h"
#include "brim/world/substeps.h"
#include "brim/world/world_impl.h"

namespace brim {

namespace {

/// Motion of a sub-step relative to the limit, above which it is solved again in pieces.
constexpr double kOutrun = 1.25;

/// [m/s²] gravity of the earth.
constexpr double kEarth = 9.81;

}  // namespace

void World::Impl::prescribe(double dt) {
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (is_frozen(b)) continue;
    bodies[b]->prescribe(state.time, dt, q(b), v(b));
    if (sleep.asleep(b) && std::any_of(v(b).begin(), v(b).end(), [](double x) { return x != 0.0; })) sleep.wake(b);
  }
  if (!sleep.on()) return;
  std::vector<int> pushed;
  actions.find_changing(state.time, dt, pushed);
  for (const int b : pushed) sleep.wake(static_cast<std::size_t>(b));
  sleep.mark(parts, state.v, first_v);
}

void World::Impl::find_contacts(double dt, StepReport& report) {
  do {
    stage.find(parts, state.v, first_v, dt, held_pairs, options, report);
    {
      const ScopedSeconds timer(report.seconds[static_cast<std::size_t>(Phase::Detect)]);
      if (filter.size() > 0) filter.moved(), filter.apply(parts, stage.contacts());
      levels.shift().apply(stage.contacts());
    }
    self_contact.find(parts, state.v, first_v, dt, options, report, stage.contacts());
    const ScopedSeconds timer(report.seconds[static_cast<std::size_t>(Phase::Detect)]);
    fill.find(bodies, parts, options, filter, stage.contacts());
  } while (sleep.on() && wake_touched());
}

bool World::Impl::solve_substep(double dt, StepReport& report) {
  check_stop();
  const auto seconds = [&](Phase p) -> double& { return report.seconds[static_cast<std::size_t>(p)]; };
  prescribe(dt);
  {
    const ScopedSeconds timer(seconds(Phase::Advance));
    update_bodies();
  }

  if (filter.size() > 0) filter.moved();
  coupling.find(bodies, parts, filter, state.q, first_v, {});
  if (sleep.on()) wake_in_fluids();
  find_contacts(dt, report);
  tell_touched();
  check_stop();
  if (!links.empty())
    links.append(parts, state.q, first_q, static_cast<int>(parts.size()) - 1, state.time, dt, stage.contacts());
  ContactSet& contacts = stage.contacts();
  velocity_a.resize(contacts.size()), velocity_b.resize(contacts.size());
  {
    const ScopedSeconds timer(seconds(Phase::Respond));
    laws.choose(parts, state.v, first_v, options, stage);
    laws.leave_to_links(parts, contacts, contacts.first_link_pair());
    response.find_normals(contacts, laws.penalties());
    place_under_balls(parts, response.normals(), contacts);
    maps.build(parts, contacts, first_v);
    maps.for_directed([&](std::size_t c, const Vec3& n) { response.set_normal(c, n); });
    maps.velocities(state.v, velocity_a, velocity_b);
    turning.begin(parts, contacts, state.v, first_v, dt);
    if (turning.any()) turning.add_slips(contacts, response.normals(), velocity_a, velocity_b);
    const double g = options.environment.gravity.norm();
    PenaltyOptions p;
    p.dt = dt;
    p.damping = options.damping_steps * options.time_step;
    // Without gravity, that of the earth: friction divided by a speed near zero would exceed single precision.
    p.friction_speed = options.friction_speed > 0.0 ? options.friction_speed
                                                    : std::max(1e-3 * (g > 0.0 ? g : kEarth) * options.time_step, 1e-9);
    p.release_speed = 0.2 * g * dt;
    p.slack = g * dt * dt;
    response.begin(contacts, laws.penalties(), p, velocity_a, velocity_b);
    fill.begin(bodies, first_v, state.v, velocity_a, velocity_b, dt, response);
    if (contacts.link_pairs > 0) links.begin(contacts, velocity_a, velocity_b, response);
  }

  {
    const ScopedSeconds timer(seconds(Phase::Respond));
    const double g = options.environment.gravity.norm();
    ConstraintStep::Settings s;
    s.rows = {dt, 2.0 * g * dt, options.constraint_every_node};
    s.tolerance = options.constraint_tolerance;
    s.max_sweeps = options.constraint_sweeps;
    s.scale = std::max(g * dt, 1e-6);
    constraints.begin(bodies, first_v, parts, contacts, response.normals(), laws.constraints(), stage.rigid().gather(),
                      state.v, s, ReferencePoses::rows_of(state.warm_start));
  }

  for (std::size_t b = 0; b < bodies.size(); ++b) {
    auto* balls = interface_of<SpinningBalls>(*bodies[b]);
    if (balls == nullptr) continue;
    std::vector<double> load(v(b).size() / 6, 0.0);
    const auto body = static_cast<std::int32_t>(b);
    add_fixed_loads(
        parts, contacts, body, [&](std::size_t c) { return response.expected_load(c); }, load);
    add_fixed_loads(
        parts, constraints.points(), body, [&](std::size_t c) { return constraints.first_impulse(c) / dt; }, load);
    balls->set_loads(load);
  }

  ImplicitStep::Settings settings;
  settings.dt = dt;
  settings.tolerance = options.cg_tolerance;
  settings.max_iterations = options.cg_max_iterations;
  settings.passes = options.max_passes;
  std::vector<std::uint8_t> asleep(sleep.on() || !edits.frozen.empty() ? bodies.size() : 0);
  for (std::size_t b = 0; b < asleep.size(); ++b) asleep[b] = sleep.asleep(b) || is_frozen(b);
  settings.asleep = asleep;
  delta.resize(state.v.size());
  std::span<const double> impulse = constraints.impulse();
  if (!actions.empty()) {
    settings.gravity_scale = actions.gravity_scale();
    impulse = actions.impulse(bodies, parts, state.q, first_q, state.v, first_v, options.environment, state.time, dt,
                              impulse);
  }
  ImplicitStep::Correct rows;
  if (!constraints.empty())
    rows = [&](const ImplicitStep::Respond& solve, std::span<double> change, std::span<double> added) {
      return constraints.correct(solve, change, added, report);
    };
  std::span<const std::vector<Mat3>> resistance;
  if (!actions.empty()) resistance = actions.resistance();
  const StepContext context{bodies,   first_v, parts,   options.environment, state.v, contacts, maps, response, fill,
                            coupling, report,  impulse, resistance};
  return implicit.solve(context, settings, delta, rows);
}

double World::Impl::motion_pieces(std::span<const double> velocities, double time, double change) {
  return std::max(brim::motion_pieces(parts, velocities, first_v, options, time, change, held_pairs, motion_sweep),
                  self_contact.motion_pieces(parts, velocities, first_v, options, time, change, motion_sweep));
}

double World::Impl::substep(double left, StepReport& report) {
  const auto seconds = [&](Phase p) -> double& { return report.seconds[static_cast<std::size_t>(p)]; };
  auto presence = std::make_optional<ScopedSeconds>(seconds(Phase::Presence));
  const double g = options.environment.gravity.norm();
  held_pairs = state.step == 0 && report.substeps == 0
                   ? HeldPairs()
                   : HeldPairs(RowMemory::pairs(ReferencePoses::rows_of(state.warm_start)));
  const double pieces = std::max(motion_pieces(state.v, left, g * left), fall_pieces(parts, g, left));
  double dt = choose_substep(pieces, options, left, report);
  presence.reset();
  before_q = state.q;
  before_v = state.v;
  const std::size_t warnings = report.warnings.size();
  bool finite = solve_substep(dt, report);
  // Contact may throw a body faster than predicted from the speeds before: cut again, once.
  if (finite && report.substeps + 1 < options.max_substeps) {
    advance_v = state.v;
    for (std::size_t i = 0; i < advance_v.size(); ++i) advance_v[i] += delta[i];
    presence.emplace(seconds(Phase::Presence));
    const double needed = std::max(motion_pieces(advance_v, dt, 0.0),
                                   thrown_pieces(parts, delta, first_v, options, dt, held_pairs, motion_sweep));
    presence.reset();
    if (needed > kOutrun) {
      state.q = before_q;
      state.v = before_v;
      fresh.clear();
      report.warnings.erase(report.warnings.begin() + static_cast<std::ptrdiff_t>(warnings), report.warnings.end());
      dt /= std::ceil(needed);
      finite = solve_substep(dt, report);
    }
  }
  ++report.substeps;
  const bool last = left - dt <= 1e-9 * options.time_step;
  const ContactSet& contacts = stage.contacts();
  report.contacts = static_cast<std::int64_t>(contacts.first_link()) + stage.rigid().contacts();
  if (!finite) {
    state.q = before_q;
    state.v = before_v;
    fresh.clear();
    report.ok = false;
    report.warnings.push_back(
        {state.time, "not_finite", "the solve gave values that are not finite; the state before it is kept"});
    return left;
  }

  {
    const ScopedSeconds timer(seconds(Phase::Respond));
    normal_force.resize(contacts.size()), friction_force.resize(contacts.size());
    response.forces(implicit.contact_delta(), normal_force, friction_force);
    fill.add_forces(normal_force);
    report_pairs(parts, contacts, normal_force, friction_force, state.time, report, samples);
    stage.rigid().report(parts, state.time, report);
    // Before stiff contact has separated overlapping bodies.
    if (state.step == 0 && report.substeps == 1) warn_of_start(parts, state.time, report);
    for (std::size_t c = 0; c < contacts.size(); ++c) normal_force[c] += friction_force[c];
    std::vector<double> mapped(last && contacts.size() > 0 ? state.v.size() : 0, 0.0);
    if (last && contacts.size() > 0) {
      maps.add_forces(normal_force, mapped);
      check_momentum(bodies, first_v, parts, contacts, mapped, normal_force, report);
    }
    tell_walled(dt, mapped);
    if (!links.empty()) {
      links.finish(contacts, normal_force, state.time, report);
      keep_apart();
    }
    constraints.finish(report, samples, last, state.warm_start);
    if (!constraints.empty() && !constraints.converged()) warn_of_mass_ratio(parts, laws, options, state.time, report);
    resist_rolling(parts, first_v, report.pairs, laws, options, dt, state.v, delta);
    coupling.report(dt, report, samples);
    report.contact_energy = response.energy();
    for (const auto& w : watchers) w->substep(*self, state.time, dt);
  }
  const ScopedSeconds timer(seconds(Phase::Advance));
  for (std::size_t i = 0; i < state.v.size(); ++i) state.v[i] += delta[i];
  advance_v = state.v;
  for (std::size_t i = 0; i < constraints.position_correction().size(); ++i)
    advance_v[i] += constraints.position_correction()[i];
  flight.find(bodies, parts, stage, filter, laws, actions, options);
  coupling.for_pairs([&](int fluid, int solid) {
    flight.hold(static_cast<std::size_t>(fluid)), flight.hold(static_cast<std::size_t>(solid));
  });
  parallel_for(bodies.size(), [&](std::size_t b) {
    if (sleep.asleep(b) || is_frozen(b)) return;
    const ProfileScope scope("advance", *bodies[b]);
    const auto own = [&](const std::vector<double>& x) { return std::span(x).subspan(first_v[b], v(b).size()); };
    bodies[b]->advance(dt, q(b), own(advance_v));
    bodies[b]->finish_step(state.time, dt, q(b), v(b));
    if (flight.flies(b)) FreeFlight::set_back(*bodies[b], dt, own(delta), own(advance_v), q(b), v(b));
    auto* kept = flight.is_free(b) ? interface_of<KeepsEnergy>(*bodies[b]) : nullptr;
    if (kept != nullptr) kept->keep_energy(state.time + dt, q(b), v(b));
  });
  stir();
  levels.shift().pass(dt);
  state.time += dt;
  if (!coupling.empty()) {
    // The masses of faces change as solids move; at the start of a step they must follow from the state alone.
    update_bodies();
    if (filter.size() > 0) filter.moved();
    coupling.find(bodies, parts, filter, state.q, first_v, state.v);
  }
  return dt;
}

}  // namespace brim
